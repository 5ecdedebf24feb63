"""Reference vectors for tests/geometry.rs: link poses and Jacobians computed by Pinocchio.

    python3 make_vectors.py pr2.urdf > kinematics.json

Two trees: the right arm of a PR2 description with all the joints between its root and its tool frame, and a synthetic tree that
has every kind of joint, mimic joints included. Poses are [x, y, z, qx, qy, qz, qw].
"""

import json
import math
import sys
import xml.etree.ElementTree as ET

import numpy as np
import pinocchio as pin

KINDS = {"fixed": "fixed", "revolute": "revolute", "continuous": "revolute", "prismatic": "prismatic"}


def pose(M):
    return [float(v) for v in M.translation] + [float(v) for v in pin.Quaternion(M.rotation).coeffs()]


def origin(joint):
    o = joint.find("origin")
    xyz = [float(v) for v in (o.get("xyz", "0 0 0") if o is not None else "0 0 0").split()]
    rpy = [float(v) for v in (o.get("rpy", "0 0 0") if o is not None else "0 0 0").split()]
    return pin.SE3(pin.rpy.rpyToMatrix(*rpy), np.array(xyz))


def tree(urdf, keep):
    """Joints of the URDF whose child is in `keep`, parents first, as our tree has them."""
    joints = {j.find("child").get("link"): j for j in urdf.findall("joint")}
    root = next(l.get("name") for l in urdf.findall("link") if l.get("name") not in joints)
    links, out, dofs = [root], [], []
    pending = [l for l in joints if l in keep]
    leaders = {}
    while pending:
        child = next(c for c in pending if joints[c].find("parent").get("link") in links)
        pending.remove(child)
        j = joints[child]
        axis = j.find("axis")
        axis = np.array([float(v) for v in axis.get("xyz").split()]) if axis is not None else np.array([1.0, 0, 0])
        entry = {
            "name": j.get("name"),
            "kind": KINDS[j.get("type")],
            "parent": links.index(j.find("parent").get("link")),
            "X_PJ": pose(origin(j)),
            "axis": [float(v) for v in axis / np.linalg.norm(axis)],
            "drive": None,
        }
        if j.get("type") != "fixed":
            mimic = j.find("mimic")
            if mimic is None:
                limit = j.find("limit")
                endless = j.get("type") == "continuous"
                leaders[j.get("name")] = len(dofs)
                dofs.append(
                    {
                        "name": j.get("name"),
                        "lower": None if endless else float(limit.get("lower")),
                        "upper": None if endless else float(limit.get("upper")),
                        "max_velocity": float(limit.get("velocity")),
                    }
                )
                entry["drive"] = [len(dofs) - 1, 1.0, 0.0]
            else:
                leader = leaders[mimic.get("joint")]
                entry["drive"] = [leader, float(mimic.get("multiplier", 1)), float(mimic.get("offset", 0))]
        links.append(child)
        out.append(entry)
    return {"links": links, "joints": out, "dofs": dofs}


def cases(model, tree, base, tip, rng, n):
    """Random configurations with the pose of every link in the root's frame, and tool pose and Jacobian in the base's frame."""
    data = model.createData()
    base_id, tip_id = model.getFrameId(base), model.getFrameId(tip)
    X_LT = pin.SE3(pin.exp3(rng.uniform(-1, 1, 3)), rng.uniform(-0.2, 0.2, 3))
    way = []
    link = tree["links"].index(tip)
    while link != tree["links"].index(base):
        way.append(tree["joints"][link - 1])
        link = way[-1]["parent"]
    columns = []
    for joint in reversed(way):
        if joint["drive"] and joint["drive"][0] not in columns:
            columns.append(joint["drive"][0])
    out = []
    for _ in range(n):
        q = []
        for dof in tree["dofs"]:
            q.append(float(rng.uniform(-3, 3) if dof["lower"] is None else rng.uniform(dof["lower"], dof["upper"])))
        full = pin.neutral(model)
        for joint in tree["joints"]:
            if joint["drive"] is None:
                continue
            dof, scale, offset = joint["drive"]
            value = q[dof] * scale + offset
            j = model.joints[model.getJointId(joint["name"])]
            if j.nq == 2:
                full[j.idx_q], full[j.idx_q + 1] = math.cos(value), math.sin(value)
            else:
                full[j.idx_q] = value
        pin.computeJointJacobians(model, data, full)
        pin.updateFramePlacements(model, data)
        X_WK, X_WL = data.oMf[base_id], data.oMf[tip_id]
        X_WT = X_WL * X_LT
        J = pin.getFrameJacobian(model, data, tip_id, pin.LOCAL_WORLD_ALIGNED)
        # From the tip link's origin to the tool's: v_T = v_L + w x p_LT.
        p = X_WT.translation - X_WL.translation
        J[:3] += np.cross(J[3:].T, p).T
        R_KW = X_WK.rotation.T
        J_K = np.vstack([R_KW @ J[:3], R_KW @ J[3:]])
        on_way = {joint["name"] for joint in way}
        jacobian = []
        for dof in columns:
            column = np.zeros(6)
            for joint in tree["joints"]:
                if joint["drive"] and joint["drive"][0] == dof and joint["name"] in on_way:
                    column += joint["drive"][1] * J_K[:, model.joints[model.getJointId(joint["name"])].idx_v]
            jacobian.append([float(v) for v in column])
        out.append(
            {
                "q": q,
                "X_BL": [pose(data.oMf[model.getFrameId(l)]) for l in tree["links"]],
                "X_KT": pose(X_WK.actInv(X_WT)),
                "J_KT": jacobian,
            }
        )
    return {"base": base, "tip": tip, "X_LT": pose(X_LT), "columns": columns, "cases": out}


def synthetic(rng):
    """A random tree of 14 joints of every kind; two of them follow another."""
    lines = ['<robot name="synthetic">', '<link name="L0"/>']
    kinds = ["revolute", "prismatic", "fixed", "continuous", "revolute", "mimic", "fixed", "revolute"]
    kinds += ["prismatic", "revolute", "continuous", "mimic", "revolute", "revolute"]
    parents = [0, 1, 2, 3, 4, 5, 6, 7, 3, 9, 10, 11, 4, 13]
    for i, (kind, parent) in enumerate(zip(kinds, parents)):
        xyz, rpy, axis = rng.uniform(-0.5, 0.5, 3), rng.uniform(-3, 3, 3), rng.normal(size=3)
        axis /= np.linalg.norm(axis)
        lines.append(f'<link name="L{i + 1}"><inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link>')
        lines.append(f'<joint name="J{i}" type="{"revolute" if kind == "mimic" else kind}">')
        lines.append(f'<parent link="L{parent}"/><child link="L{i + 1}"/>')
        lines.append('<origin xyz="%.17g %.17g %.17g" rpy="%.17g %.17g %.17g"/>' % (*xyz, *rpy))
        lines.append('<axis xyz="%.17g %.17g %.17g"/>' % tuple(axis))
        if kind != "fixed":
            lines.append('<limit lower="-1.2" upper="1.5" velocity="1" effort="1"/>')
        if kind == "mimic":
            lines.append('<mimic joint="J4" multiplier="-0.7" offset="0.3"/>')
        lines.append("</joint>")
    lines.append("</robot>")
    return "\n".join(lines)


def main():
    rng = np.random.default_rng(7)
    trees = []

    text = open(sys.argv[1]).read()
    urdf = ET.fromstring(text)
    parents = {j.find("child").get("link"): j.find("parent").get("link") for j in urdf.findall("joint")}
    keep, link = set(), "r_gripper_tool_frame"
    while link in parents:
        keep.add(link)
        link = parents[link]
    arm = tree(urdf, keep)
    model = pin.buildModelFromXML(text)
    chain = cases(model, arm, "torso_lift_link", "r_gripper_tool_frame", rng, 8)
    trees.append({"name": "PR2, right arm", "tree": arm, "chain": chain})

    text = synthetic(rng)
    urdf = ET.fromstring(text)
    whole = tree(urdf, {l.get("name") for l in urdf.findall("link")})
    model = pin.buildModelFromXML(text)
    chain = cases(model, whole, "L1", "L8", rng, 8)
    trees.append({"name": "synthetic", "tree": whole, "chain": chain})

    json.dump({"tool": "Pinocchio", "version": pin.__version__, "trees": trees}, sys.stdout, indent=None, separators=(",", ":"))
    print()


if __name__ == "__main__":
    main()
