"""Writes the reference vectors of tests/vendors: link poses of makers' robots by Pinocchio.

    python3 tests/vendors/reference.py FOLDER

FOLDER is the one that holds the package example-robot-data (PyPI: example-robot-data 6.0; PyPI: pin 4.1).
Poses are [x, y, z, qx, qy, qz, qw] in the root link's frame.
"""
import json
import os
import random
import sys

import pinocchio

sys.path.insert(0, "tests/world")
import reference  # noqa: E402

ROBOTS = {
    "panda": "panda_description/urdf/panda.urdf",
    "ur5": "ur_description/urdf/ur5_gripper.urdf",
    "pr2": "pr2_description/urdf/pr2.urdf",
    "tiago_pro": "tiago_pro_description/robots/tiago_pro.urdf",
    "tiago": "tiago_description/robots/tiago.urdf",
}

for seed, (name, path) in enumerate(ROBOTS.items()):
    urdf = os.path.join(sys.argv[1], "example-robot-data/robots", path)
    model = pinocchio.buildModelFromUrdf(urdf, mimic=True)
    links = [f.name for f in model.frames if f.type == pinocchio.BODY]
    configurations = reference.configurations(model, random.Random(40 + seed), 3)
    cases = [{"q": q, "links": reference.link_poses(model, q, links)} for q in configurations]
    with open(f"tests/vendors/{name}_fk.json", "w") as out:
        head = {"tool": f"Pinocchio {pinocchio.__version__}", "urdf": path}
        out.write(json.dumps(head)[:-1] + ', "cases": [\n')
        out.write(",\n".join(json.dumps(case) for case in cases) + "\n]}\n")
