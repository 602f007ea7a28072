"""The rod in Drake: a planar joint, a small sphere at the end, a half space, discrete contact."""

import math
from importlib.metadata import version

from pydrake.geometry import AddContactMaterial, HalfSpace, ProximityProperties, Sphere
from pydrake.math import RigidTransform
from pydrake.multibody.plant import (
    AddMultibodyPlantSceneGraph,
    CoulombFriction,
    DiscreteContactApproximation,
)
from pydrake.multibody.tree import PlanarJoint, SpatialInertia, UnitInertia
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder
from rod import MU, G, J, L, M, report

RADIUS = 1e-3


def maker(approximation, stiffness, mu=MU):
    """Return a function that makes the plant with an approximation, a stiffness and friction."""

    def make(h, q, u):
        builder = DiagramBuilder()
        plant, _ = AddMultibodyPlantSceneGraph(builder, time_step=h)
        plant.set_discrete_contact_approximation(approximation)
        plant.mutable_gravity_field().set_gravity_vector([0, -G, 0])
        unit = UnitInertia(J / M, J / M, J / M)
        body = plant.AddRigidBody("rod", SpatialInertia(M, [0, 0, 0], unit))
        joint = plant.AddJoint(
            PlanarJoint("planar", plant.world_frame(), body.body_frame(), damping=[0, 0, 0])
        )
        props = ProximityProperties()
        AddContactMaterial(
            dissipation=0.0, point_stiffness=stiffness, friction=CoulombFriction(mu, mu),
            properties=props,
        )  # fmt: skip
        if approximation == DiscreteContactApproximation.kSap:
            props.AddProperty("material", "relaxation_time", 0.0)
        x, y = -L + RADIUS * math.sin(q[2]), RADIUS * math.cos(q[2])
        at = RigidTransform([x, y, 0])
        plant.RegisterCollisionGeometry(body, at, Sphere(RADIUS), "end", props)
        ground = HalfSpace.MakePose([0, 1, 0], [0, 0, 0])
        plant.RegisterCollisionGeometry(plant.world_body(), ground, HalfSpace(), "ground", props)
        plant.Finalize()
        simulator = Simulator(builder.Build())
        context = plant.GetMyMutableContextFromRoot(simulator.get_mutable_context())
        joint.set_translation(context, q[:2])
        joint.set_rotation(context, q[2])
        joint.set_translational_velocity(context, u[:2])
        joint.set_angular_velocity(context, u[2])
        simulator.Initialize()
        count = 0

        def step():
            nonlocal count
            count += 1
            simulator.AdvanceTo(count * h)
            values = plant.GetPositionsAndVelocities(context).tolist()
            return values[:3], values[3:]

        return step

    return make


if __name__ == "__main__":
    kinds = DiscreteContactApproximation
    settings = {
        f"{name}, {stiffness:.0e} N/m": maker(kind, stiffness)
        for name, kind in (
            ("TAMSI", kinds.kTamsi),
            ("SAP", kinds.kSap),
            ("similar", kinds.kSimilar),
            ("lagged", kinds.kLagged),
        )
        for stiffness in (1e6, 1e10)
    }
    report("Drake", version("drake"), settings)
