"""Joint springs and dampers: between two bars' angles, or on a tree's own joint angle."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from adapters.exudyn.library import items

if TYPE_CHECKING:
    from scenarios import JointSpringDamper


def add_springs(mbs: Any, springs: JointSpringDamper, markers: list[tuple[Any, Any]]) -> None:
    """Connect pairs of coordinates, one pair for each joint: torque -k (difference - rest) - c rate on the second.

    The coordinates are not reduced to one revolution, so that springs wind up.

    Parameters
    ----------
    mbs : MainSystem
    springs : JointSpringDamper
    markers : list of (MarkerIndex, MarkerIndex)
        Angle before each joint and the angle behind it.
    """
    columns = zip(springs.stiffness_N_m_rad, springs.damping_N_m_s_rad, springs.rest_rad, markers, strict=True)
    for stiffness, damping, rest, pair in columns:
        mbs.AddObject(
            items().ObjectConnectorCoordinateSpringDamper(
                markerNumbers=list(pair), stiffness=stiffness, damping=damping, offset=rest
            )
        )
