"""Two bars on an orbit in Basilisk's spacecraft, the second one a hinged effector: how far gravity turns the hinge.

Runs in a Python with bsk. In `reference`, with point gravity on each bar, the hinge turns by -0.577 rad
(docs/engines/found_upstream.md has the scene).
"""

import numpy as np
from Basilisk.simulation import gravityEffector, spacecraft, spinningBodyNDOFStateEffector, svIntegrators
from Basilisk.utilities import SimulationBaseClass, macros

MASS_KG, LENGTH_M, HINGE_RAD = 100.0, 100.0, 1.0
MU_M3_S2, RADIUS_M, END_S, STEP_S = 3.986004418e14, 7e6, 600.0, 0.5
INERTIA_KG_M2 = np.diag([1e-3, 1.0, 1.0]) * MASS_KG * LENGTH_M**2 / 12.0


def main():
    """Print by how much the hinge turned."""
    simulation = SimulationBaseClass.SimBaseClass()
    simulation.CreateNewProcess("process").addTask(simulation.CreateNewTask("task", macros.sec2nano(STEP_S)))
    craft = spacecraft.Spacecraft()  # bar 1: its end is the hinge, and the origin of its axes
    craft.hub.mHub, craft.hub.IHubPntBc_B = MASS_KG, INERTIA_KG_M2.tolist()
    craft.hub.r_BcB_B = [[-LENGTH_M / 2.0], [0.0], [0.0]]
    bar = spinningBodyNDOFStateEffector.SpinningBody()
    bar.setMass(MASS_KG)
    bar.setISPntSc_S(INERTIA_KG_M2.tolist())
    bar.setDCM_S0P(np.eye(3).tolist())
    bar.setR_ScS_S([[LENGTH_M / 2.0], [0.0], [0.0]])
    bar.setR_SP_P([[0.0], [0.0], [0.0]])
    bar.setSHat_S([[0.0], [0.0], [1.0]])
    bar.setThetaInit(HINGE_RAD)
    hinge = spinningBodyNDOFStateEffector.SpinningBodyNDOFStateEffector()
    hinge.addSpinningBody(bar)
    craft.addStateEffector(hinge)
    earth = gravityEffector.GravBodyData()
    earth.planetName, earth.mu, earth.isCentralBody = "earth", MU_M3_S2, True
    craft.gravField.gravBodies = spacecraft.GravBodyVector([earth])
    craft.hub.r_CN_NInit = [[RADIUS_M], [0.0], [0.0]]
    craft.hub.v_CN_NInit = [[0.0], [np.sqrt(MU_M3_S2 / RADIUS_M)], [0.0]]
    craft.hub.sigma_BNInit = craft.hub.omega_BN_BInit = [[0.0], [0.0], [0.0]]
    integrator = svIntegrators.svIntegratorRK4(craft)
    craft.setIntegrator(integrator)
    record = hinge.spinningBodyOutMsgs[0].recorder()
    for model in (craft, hinge, record):
        simulation.AddModelToTask("task", model)
    simulation.InitializeSimulation()
    simulation.ConfigureStopTime(macros.sec2nano(END_S))
    simulation.ExecuteSimulation()
    print(f"the hinge turned by {record.theta[-1] - record.theta[0]:.1e} rad in {record.times()[-1] * 1e-9:g} s")


if __name__ == "__main__":
    main()
