"""The words on an exception name the engine's own line, and the line of a library where the exception was raised."""

import numpy as np
import pytest

from barchain.runs.phases import exception_words

HERE = __name__


def words_of(call):
    with pytest.raises(Exception) as raised:  # noqa: PT011, the kind of error is the call's
        call()
    return exception_words(raised.value)


def divide():
    return 1 / 0


def invert():
    return np.linalg.inv(np.zeros((2, 2)))


def test_the_line_of_the_engine_is_named_and_inside_a_library_that_of_the_library_too():
    line = divide.__code__.co_firstlineno + 1
    assert words_of(divide) == f"ZeroDivisionError: division by zero ({HERE}:{line} in divide)"
    line = invert.__code__.co_firstlineno + 1
    said = words_of(invert)
    assert said.startswith(f"LinAlgError: Singular matrix ({HERE}:{line} in invert, raised in numpy.linalg")


def test_an_exception_that_was_never_raised_has_no_place():
    assert exception_words(ValueError("no")) == "ValueError: no"


def test_words_are_one_printable_line():
    def several_lines():
        raise ValueError("first\nsecond\x1b[31m")

    assert words_of(several_lines).startswith("ValueError: first second [31m (")
