"""The rod in Bullet: a free body that moves in a plane by symmetry, a small sphere at the end."""

import math
from importlib.metadata import version

import pybullet as bullet
from rod import MU, G, J, L, M, report

RADIUS = 1e-3


def maker(**engine):
    """Return a function that makes the world with parameters of the engine."""

    def make(h, q, u):
        bullet.resetSimulation()
        bullet.setGravity(0, 0, -G)
        bullet.setPhysicsEngineParameter(
            fixedTimeStep=h, numSubSteps=1, solverResidualThreshold=0.0, **engine
        )
        ground = bullet.createMultiBody(
            baseMass=0,
            baseCollisionShapeIndex=bullet.createCollisionShape(bullet.GEOM_PLANE),
        )
        x, z = -L + RADIUS * math.sin(q[2]), RADIUS * math.cos(q[2])
        shape = bullet.createCollisionShape(
            bullet.GEOM_SPHERE, radius=RADIUS, collisionFramePosition=[x, 0, z]
        )
        turn = bullet.getQuaternionFromEuler([0, -q[2], 0])
        rod = bullet.createMultiBody(
            baseMass=M,
            baseCollisionShapeIndex=shape,
            basePosition=[q[0], 0, q[1]],
            baseOrientation=turn,
        )
        bullet.changeDynamics(ground, -1, lateralFriction=MU, restitution=0)
        bullet.changeDynamics(
            rod, -1, lateralFriction=1.0, rollingFriction=0, spinningFriction=0, restitution=0,
            linearDamping=0, angularDamping=0, localInertiaDiagonal=[J, J, J],
            maxJointVelocity=1e9, activationState=bullet.ACTIVATION_STATE_DISABLE_SLEEPING,
        )  # fmt: skip
        bullet.performCollisionDetection()
        bullet.resetBaseVelocity(rod, [u[0], 0, u[1]], [0, -u[2], 0])

        def step():
            bullet.stepSimulation()
            place, turned = bullet.getBasePositionAndOrientation(rod)
            velocity, rate = bullet.getBaseVelocity(rod)
            angle = 2 * math.atan2(-turned[1], turned[3])
            return [place[0], place[2], angle], [velocity[0], velocity[2], -rate[1]]

        return step

    return make


if __name__ == "__main__":
    bullet.connect(bullet.DIRECT)
    settings = {
        "defaults": maker(),
        "1000 iterations, no correction of overlap": maker(
            numSolverIterations=1000, erp=0.0, contactERP=0.0
        ),
    }
    report("Bullet (pybullet)", version("pybullet"), settings)
