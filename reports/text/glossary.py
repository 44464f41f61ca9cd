"""Terms of the reports, each explained where it first stands on a page."""

from __future__ import annotations

from reports.tables.crossval import PARTED_RAD

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
"""Definition of each term"""


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
