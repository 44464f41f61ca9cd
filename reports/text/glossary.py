"""Terms of the reports, each explained where it first stands on a page, and terms of the field."""

from __future__ import annotations

from reports.results.comparison import PARTED_RAD

TERMS = {
    "reference solution": "Run of the reference at tight tolerances, with an estimate of its error. A comparison "
    "takes it where a scene has no certified solution.",
    "judging solution": "Solution with which every engine's run is compared: a certified solution in quadruple "
    "precision from independent equations, or else a tight run of the reference. Its own error enters every tolerance.",
    "certified solution": "Solution in quadruple precision from independently derived equations, with an error bar for "
    "each quantity.",
    "independent engine": "Engine with its library's equations of motion, or (heyoka) with equations that were derived "
    "a second time for it. The other engines integrate the reference's equations.",
    "normalised error": "Difference from the judging solution, divided by its explained part: both error estimates, "
    "round-off and the declared model difference. Up to 1 the difference is explained.",
    "expected-error bound": "Largest error that the engine's method may make at its setting in this scene. The bound "
    "follows from the order of the method and from the error amplification.",
    "error amplification": "Factor by which a small perturbation of the initial angles and rates has grown in the "
    "attitude. A second run measures the factor. Its initial angles and rates are perturbed by up to "
    "10⁻¹⁰ (rad; relative to the orbital rate). Another run, perturbed by 10⁻¹⁸, measures growth beyond 10⁸.",
    "predictability limit": f"Last instant at which two correct runs at this setting agree to {PARTED_RAD:g} rad. "
    "Later attitudes are not compared point by point.",
    "detection limit": "Relative error that the comparison would have reported as a failure at whichever sample it "
    "occurred. Smaller ones are seen at some samples only.",
    "centre-of-mass residual": "Distance between the centre of mass and the mass-weighted mean of the bars' centres: "
    "the residual of the paper's equation (6).",
    "accuracy parameter": "Setting that controls an engine's error: a number of equal steps, or a tolerance.",
    "accuracy sweep": "Runs of one engine at several values of its accuracy parameter, from coarse to fine.",
    "work-precision front": "Runs that no other run of the same kind of engine beats in both time and error.",
    "evaluation": "One evaluation of the right-hand side: all accelerations and reactions of one state.",
    "size ratio ε": "Length of a bar, divided by the Earth's radius.",
    "unit round-off u": "Largest relative error of rounding a number: 1.1×10⁻¹⁶ in double precision (float64), "
    "6.0×10⁻⁸ in single precision (float32).",
    "absolute coordinates": "Positions measured from the centre of the body; relative ones are measured from the "
    "chain's centre of mass.",
    "inserted fault": "Known error that is inserted into an engine on purpose, to test whether the checks detect it.",
    "control": "Engine without a fault; every check must accept its runs.",
    "resolved": "Larger than the numerical error of both runs.",
    "perturbed run": "Run of the same scene with slightly different initial values or parameters.",
}
"""Terms of the reports with their definitions"""

FIELD = {
    "adapter": "The part of barchain, or of a package of its own, that builds a scene's chain in another engine and "
    "returns its motion.",
    "attitude": "Angles of the bars from an inertial axis.",
    "centre of mass (CM)": "Of the whole chain; its motion is the orbit.",
    "chain": "N rigid bars, joined end to end by N − 1 revolute joints.",
    "channel": "One quantity over time, e.g. `reaction`: stored as an array of a trajectory, or derived from those.",
    "chaos": "Growth of any small difference by a factor in equal times, until it is as large as the motion: no engine "
    "and no solution says what follows the predictability limit.",
    "Encke's form": "Differences of gravity from a nearby reference, written so that no large numbers are subtracted.",
    "end body": "A body with its own mass and inertia at an end of the chain: a hub, a satellite, the base of an arm.",
    "engine": "A library's solver, or one of barchain's, with the formulation and the integrator that its adapter "
    "chooses.",
    "explained to": "What a mistake that `judge` names leaves of the differences, relative to the quantity's size: the "
    "largest of all quantities.",
    "gap": "Distance of the two bar ends that a joint ties.",
    "gradient torque": "Torque of gravity on a bar, because gravity is stronger at the lower end.",
    "ideal joint": "A revolute joint without friction, clearance or a stop, as all joints of a chain are; springs and "
    "dampers in it are linear.",
    "index 2, index 3": "Constraints of a differential-algebraic system enforced on velocities, on positions.",
    "Lagrange multipliers": "Forces that enforce constraints in redundant coordinates; here the reactions.",
    "latch": "A moving joint is caught: an impact without rebound, by `latched` in Python.",
    "libration": "Swing of a chain about the local vertical, by gravity's gradient.",
    "local angle φ": "Angle of a bar from the local horizontal.",
    "local horizontal": "Direction of the radius turned by −90°.",
    "lock": 'A joint that is held at its angle: a prescribed rotation of no amplitude with `frame = "previous_bar"`.',
    "mean motion n": "√(μ/r³), rate of a circular orbit.",
    "minimal coordinates": "Centre of mass and angles: joints are closed by construction.",
    "orbit of a scene": "Period of the osculating ellipse at the start, or of the circular orbit at that radius.",
    "point gravity": "Gravity as if a bar's mass were at its centre.",
    "prescribed rotation": "A bar that turns by a given law; an actuator's torque makes it do so. Also called a slew.",
    "reaction": "Force in a joint, on bar j from bar j+1.",
    "redundant coordinates": "Position and angle of each bar, tied by constraints.",
    "relative coordinates": "Places counted from the chain's centre of mass.",
    "restart": "Run of the reference from a state of the run that is judged, over one sample: what is compared beyond "
    "the predictability limit.",
    "scene": "A TOML file: orbit, chain, effects, run.",
    "set point": "Rest angle of a joint's spring that moves by a table: a spring and a damper then are a PD control.",
    "tether": "A chain of long bars, with end bodies as its satellites.",
    "tree, joint-tree coordinates": "Position of one bar and joint angles.",
}
"""Terms of the field, and of barchain's documents, with their meanings"""


class Glossary:
    """Terms explained so far on one page."""

    def __init__(self) -> None:
        self.explained: set[str] = set()

    def first(self, *terms: str) -> list[tuple[str, str]]:
        """Terms that the page has not explained yet, with their definitions.

        Raises
        ------
        KeyError
            If a term has no definition.
        """
        found = [(term, TERMS[term]) for term in terms if term not in self.explained]
        self.explained.update(terms)
        return found
