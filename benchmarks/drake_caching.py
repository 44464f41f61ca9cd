"""Error of Drake's integrators on a bare double pendulum, with caching and without.

With caching RK5 and BS3 repeat a rejected step with a derivative of the rejected state; RK3 does not.
"""

import numpy as np
from pydrake.math import RigidTransform
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import FixedOffsetFrame, RevoluteJoint, RotationalInertia, SpatialInertia
from pydrake.systems.analysis import ResetIntegratorFromFlags, Simulator

LONGEST_STEP_S = 0.1  # with caching and a longest step of 10 s RK5 does not end


def double_pendulum():
    """Two links of 1 m and 1 kg."""
    plant = MultibodyPlant(time_step=0.0)
    frame = plant.world_frame()
    for name in ("upper", "lower"):
        inertia = SpatialInertia.MakeFromCentralInertia(1.0, [0.5, 0.0, 0.0], RotationalInertia(1 / 12, 1 / 12, 1 / 12))
        link = plant.AddRigidBody(name, inertia).body_frame()
        plant.AddJoint(RevoluteJoint(f"{name}_joint", frame, link, [0.0, 0.0, 1.0]))
        frame = plant.AddFrame(FixedOffsetFrame(f"{name}_end", link, RigidTransform([1.0, 0.0, 0.0])))
    plant.mutable_gravity_field().set_gravity_vector([0.0, -9.81, 0.0])
    plant.Finalize()
    return plant


def state_after_3_s(scheme, accuracy, *, caching):
    """State at the end, and the number of rejected steps."""
    simulator = Simulator(double_pendulum())
    context = simulator.get_mutable_context()
    if not caching:
        context.DisableCaching()
    context.SetContinuousState([-0.7, 0.5, 0.0, 0.0])
    ResetIntegratorFromFlags(simulator, scheme, LONGEST_STEP_S)
    simulator.get_mutable_integrator().set_target_accuracy(accuracy)
    simulator.Initialize()
    simulator.AdvanceTo(3.0)
    rejected = simulator.get_integrator().get_num_step_shrinkages_from_error_control()
    return context.get_continuous_state_vector().CopyToVector(), rejected


def main():
    """Print a line for each integrator and accuracy."""
    true, _ = state_after_3_s("runge_kutta5", 1e-11, caching=False)
    for scheme in ("runge_kutta3", "bogacki_shampine3", "runge_kutta5"):
        for accuracy in (1e-4, 1e-5, 1e-6, 1e-7):
            found = [state_after_3_s(scheme, accuracy, caching=caching) for caching in (True, False)]
            said = [f"error {np.abs(state - true).max():.1e}, {rejected} rejected" for state, rejected in found]
            print(f"{scheme} at {accuracy:g}: with caching {said[0]}; without {said[1]}", flush=True)


if __name__ == "__main__":
    main()
