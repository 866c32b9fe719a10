"""Compares H and b of (1) with what MuJoCo and Pinocchio compute from the exported robot; prints the greatest differences.

    python3 dynamics.py robot.xml robot.urdf states.json

Ours: velocity of the base's origin and angular velocity in W, then the joints. MuJoCo takes the angular velocity, Pinocchio
both, in the axes of the base: ν = T(x) ẋ, so H = Tᵀ H_ν T and b = Tᵀ (b_ν + H_ν Ṫ ẋ).
"""

import json
import sys
import xml.etree.ElementTree as xml

import mujoco
import numpy as np
import pinocchio as pin

mjcf, urdf, states = sys.argv[1:]
given = json.load(open(states))
names, gravity, free = given["joints"], np.array(given["gravity"]), given["free"]
offset = 6 if free else 0

world = mujoco.MjModel.from_xml_path(mjcf)
data = mujoco.MjData(world)
hinges = [world.joint(name) for name in names]

robot = pin.buildModelFromUrdf(urdf, pin.JointModelFreeFlyer()) if free else pin.buildModelFromUrdf(urdf)
robot.gravity.linear = gravity
tree = xml.parse(urdf).getroot()
rotor = {t.find("joint").get("name"): float(t.find(".//{*}rotor_inertia").get("value")) for t in tree.iter("transmission")}
damping = np.zeros(robot.nv)
armature = np.zeros(robot.nv)
for joint in tree.iter("joint"):
    if joint.find("dynamics") is not None:
        at = robot.joints[robot.getJointId(joint.get("name"))].idx_v
        damping[at] = float(joint.find("dynamics").get("damping"))
        armature[at] = rotor[joint.get("name")]
robot.armature = armature
memory = robot.createData()


def from_mujoco(x, xdot, R):
    if free:
        data.qpos[:7] = x[:7]
    for joint, angle in zip(hinges, x[-len(names) :]):
        data.qpos[joint.qposadr] = angle
    T = np.zeros((world.nv, world.nv))
    if free:
        T[:3, :3], T[3:6, 3:6] = np.eye(3), R.T
    for k, joint in enumerate(hinges):
        T[joint.dofadr[0], offset + k] = 1.0
    data.qvel[:] = T @ xdot
    mujoco.mj_forward(world, data)
    H = np.zeros((world.nv, world.nv))
    full_inertia(H)
    return T.T @ H @ T, T.T @ (data.qfrc_bias - data.qfrc_passive)  # d(Rᵀω)/dt has no term in ω × ω


def full_inertia(H):
    """Two signatures, of MuJoCo 3 and 4."""
    try:
        mujoco.mj_fullM(world, H, data.qM)
    except (TypeError, AttributeError):
        mujoco.mj_fullM(world, data, H)


def from_pinocchio(x, xdot, R):
    q, T, bend = pin.neutral(robot), np.zeros((robot.nv, robot.nv)), np.zeros(robot.nv)
    if free:
        q[:3], q[3:6], q[6] = x[:3], x[4:7], x[3]
        T[:3, :3], T[3:6, 3:6] = R.T, R.T
        bend[:3] = -R.T @ np.cross(xdot[3:6], xdot[:3])  # Ṫ ẋ
    for k, name in enumerate(names):
        joint = robot.joints[robot.getJointId(name)]
        q[joint.idx_q] = x[k - len(names)]
        T[joint.idx_v, offset + k] = 1.0
    v = T @ xdot
    H = pin.crba(robot, memory, q).copy()
    H = np.triu(H) + np.triu(H, 1).T
    b = pin.rnea(robot, memory, q, v, np.zeros(robot.nv)) + damping * v
    return T.T @ H @ T, T.T @ (b + H @ bend)


worst = {"mujoco": 0.0, "pinocchio": 0.0}
for state in given["states"]:
    x, xdot, H, b = (np.array(state[key]) for key in ("x", "xdot", "H", "b"))
    R = pin.Quaternion(x[3], x[4], x[5], x[6]).matrix() if free else np.eye(3)
    for engine, (H_its, b_its) in [("mujoco", from_mujoco(x, xdot, R)), ("pinocchio", from_pinocchio(x, xdot, R))]:
        differences = abs(H_its - H).max() / abs(H).max(), abs(b_its - b).max() / abs(b).max()
        worst[engine] = max(worst[engine], *differences)
print(json.dumps(worst))
