"""IDA (SUNDIALS): a differential-algebraic system in redundant coordinates, with the reactions as multipliers.

Formulation: Newton-Euler equations of each bar; joints as constraints of accelerations (`ida-index1`), of velocities
(`ida-index2`), of velocities and positions by Gear, Gupta and Leimkuhler (`ida-ggl`), or of positions (`ida-index3`).
Own derivation: `adapters/ida/chain.py`.
Coordinates: each bar's centre and angle in a freely falling frame, whose origin is integrated beside them.
Integrator: IDA, backward differences of order 1 to 5 with error control, Newton's method with the Jacobian in closed
form, but for loads, which are differenced. The library is the one that scikit-sundae brings along.
Accuracy parameter: `rtol`, of a step in units of the longest bar and the fastest rate; at index 3 that of rates.
Reactions: the multipliers, interpolated as IDA does. They start consistent with the state, and again at each event.

Supported: all gravity models, oblateness, third bodies, drag, solar pressure without shadow, joint springs and dampers,
thrusts, and impulses.
Not supported: prescribed rotations, for which the adapter has no constraint, and the shadow's edge, whose instant
depends on the motion.

Joints: they drift apart at index 1 and 2, by errors of steps that add up; not at index 3 and with `ida-ggl`.

Traps: multipliers, and at index 3 the rates too, are left out of the error test: with rates in it, most runs at index 3
end as `IDA_ERR_FAIL` or `IDA_CONV_FAIL`. What is left out is not controlled: reactions of `ida-index3` go with the
power 2/3 of the request. Newton's corrections of multipliers are rounded to u/h, at index 3 to u/h², and IDA gives up
where they no longer fall: its own first step, half a request, is far too short, and index 3 ends at `rtol` = 1e-8.
A step that is cut short at the end of a run makes index 3's last multipliers wrong by a tenth; the adapter steps past
the end instead. scikit-sundae's own class has no switch for the error test, and counts no steps.
"""
