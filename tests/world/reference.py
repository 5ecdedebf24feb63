"""Writes the reference vectors of tests/world: link poses by Pinocchio.

    python3 tests/world/reference.py [path of the maker's pr2.urdf]

Needs Pinocchio (PyPI: pin 4.1). The maker's PR2 is in PyPI's example-robot-data 6.0; without its path
`pr2_published.json` is left as it is. Poses are [x, y, z, qx, qy, qz, qw] in the root link's frame.
"""
import json
import math
import random
import sys

import pinocchio

HERE = "tests/world/"


def configurations(model, rng, count, names=None):
    """Yields {joint: value} within the limits, by the joints that are not mimics; continuous ones within a turn."""
    for _ in range(count):
        values = {}
        for j in range(1, model.njoints):
            joint = model.joints[j]
            if "Mimic" in joint.shortname() or (names and model.names[j] not in names):
                continue
            if joint.nq == 2:
                values[model.names[j]] = rng.uniform(-math.pi, math.pi)
            else:
                low, high = model.lowerPositionLimit[joint.idx_q], model.upperPositionLimit[joint.idx_q]
                values[model.names[j]] = rng.uniform(low, high)
        yield values


def link_poses(model, values, links):
    q = pinocchio.neutral(model)
    for name, value in values.items():
        joint = model.joints[model.getJointId(name)]
        if joint.nq == 2:
            q[joint.idx_q], q[joint.idx_q + 1] = math.cos(value), math.sin(value)
        else:
            q[joint.idx_q] = value
    data = model.createData()
    pinocchio.framesForwardKinematics(model, data, q)
    poses = {}
    for link in links:
        pose = data.oMf[model.getFrameId(link, pinocchio.BODY)]
        poses[link] = [float(v) for v in pinocchio.SE3ToXYZQUAT(pose)]
    return poses


def write(path, urdf, links, seed, count, names=None):
    model = pinocchio.buildModelFromUrdf(urdf, mimic=True)
    rng = random.Random(seed)
    links = links or [f.name for f in model.frames if f.type == pinocchio.BODY]
    cases = [
        {"q": values, "links": link_poses(model, values, links)}
        for values in configurations(model, rng, count, names)
    ]
    text = {"tool": f"Pinocchio {pinocchio.__version__}", "urdf": urdf.split("/")[-1], "cases": cases}
    with open(HERE + path, "w") as out:
        json.dump(text, out, indent=1)
        out.write("\n")


def main():
    write("pr2_fk.json", "worlds/models/pr2.urdf", None, 1, 6)
    write("human_fk.json", "worlds/models/human.urdf", None, 2, 6)
    write("arm7_fk.json", "worlds/models/arm7.urdf", None, 4, 6)
    write("quadrotor_fk.json", "worlds/models/quadrotor.urdf", None, 5, 6)
    write("humanoid_fk.json", "worlds/models/humanoid.urdf", None, 6, 6)
    if len(sys.argv) > 1:
        arm = ["shoulder_pan", "shoulder_lift", "upper_arm_roll", "elbow_flex", "forearm_roll", "wrist_flex", "wrist_roll"]
        names = {f"{side}_{joint}_joint" for side in "lr" for joint in arm}
        names |= {"torso_lift_joint", "head_pan_joint", "head_tilt_joint"}
        links = ["torso_lift_link", "head_tilt_link", "l_gripper_palm_link", "r_gripper_palm_link"]
        write("pr2_published.json", sys.argv[1], links, 3, 12, names)


if __name__ == "__main__":
    main()
