"""Laws of prescribed rotations, one of each kind."""

from reference_impl.model.chain import BarTurn, Prescription

LAWS = {
    "external, inertial": (Prescription(0, (BarTurn(0.8, 60.0, 10.0),), frame="inertial", reacts_on=None),),
    "external, local": (Prescription(1, (BarTurn(-0.8, 60.0, 10.0),), frame="local_horizontal", reacts_on=None),),
    "joint, inertial": (Prescription(1, (BarTurn(0.8, 60.0, 10.0),), frame="inertial", reacts_on=0),),
    "joint, local": (Prescription(0, (BarTurn(0.8, 60.0, 10.0),), frame="local_horizontal", reacts_on=1),),
    "two at once": (
        Prescription(0, (BarTurn(0.3, 60.0, 10.0),), frame="inertial", reacts_on=None),
        Prescription(1, (BarTurn(0.8, 60.0, 0.0),), frame="local_horizontal", reacts_on=0),
    ),
    "joint angle": (Prescription(1, (BarTurn(0.8, 60.0, 10.0),), frame="previous_bar", reacts_on=0),),
    "joint angle beside a bar's": (
        Prescription(0, (BarTurn(0.3, 60.0, 10.0),), frame="inertial", reacts_on=None),
        Prescription(1, (BarTurn(0.8, 60.0, 0.0),), frame="previous_bar", reacts_on=0),
    ),
    "all bars": "all",
}
