"""Compiler of a small part of Python to machine code of this processor, by LLVM.

The compiled reference is written in this part of Python: functions of floats, integers, Booleans, arrays and
structs, with loops and branches, without objects, allocation or exceptions. Types follow from the annotations of
parameters and from first assignments; anything else is rejected with file and line. A general compiler spends seconds
on each function to find types and to allow for all of Python; here a whole integrator takes some four.

``functions``
    The decorators ``compiled`` (a function of its own), ``inlined`` (lowered into its callers), ``through_address``
    (a call of a function whose address is known at run time) and ``built_in`` (stands for instructions).
``structs``, ``lanes``
    Named groups of arrays and numbers, passed by reference; numbers in the lanes of a vector register.
``lowering``, ``expressions``, ``arithmetic``, ``memory``, ``calls``, ``signatures``, ``unit``
    From syntax tree to LLVM's intermediate representation.
``processor``, ``target``, ``store``, ``library``
    Machine code for this processor, its folder on disk, and calls from Python.
"""
