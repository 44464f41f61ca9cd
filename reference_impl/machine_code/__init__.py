"""Compiler of a small part of Python to machine code of this processor, by LLVM.

The compiled reference is written in this part of Python: functions of floats, integers, truth values, arrays and
structs, with loops and branches, without objects, allocation or exceptions. Types follow from the annotations of
parameters and from first assignments; anything else is rejected with file and line. A general compiler spends seconds
on each function to find types and to allow for all of Python; here a whole integrator takes about one second.

:mod:`.functions`
    The decorators ``compiled`` (a function of its own), ``inlined`` (lowered into its callers) and ``through_address``
    (a call of a function whose address is known at run time).
:mod:`.structs`
    Named groups of arrays and numbers, passed by reference.
:mod:`.lowering`, :mod:`.expressions`, :mod:`.arithmetic`, :mod:`.calls`
    From syntax tree to LLVM's intermediate representation.
:mod:`.target`, :mod:`.store`, :mod:`.library`
    Machine code for this processor, its folder on disk, and calls from Python.
"""
