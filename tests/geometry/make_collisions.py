"""Reference answers for tests/geometry/collisions.rs: 10,000 random configurations each of two robots, hit or free by coal.

    python3 make_collisions.py panda.urdf PACKAGE_DIR ../../worlds/models/pr2.urdf > collisions.json

The first robot is a maker's: each collision mesh becomes the polytope whose planes touch it in 26 directions (26-DOP), given by its
planes here and by its corners to coal. The second is ours, of primitives. Around each stand 20 boxes, cylinders, spheres and capsules.
Poses are [x, y, z, qx, qy, qz, qw]. Configurations come from the generator below, uniform within the limits ([-pi, pi] without).
"""

import itertools
import json
import math
import sys
import xml.etree.ElementTree as ET

import coal
import numpy as np
import pinocchio as pin

from make_vectors import origin, pose, tree

N = 10_000
N_OBJECTS = 20


class Random:
    """Knuth's 64-bit linear congruential generator; the upper 53 bits are a number in [0, 1)."""

    def __init__(self, seed):
        self.state = seed

    def __call__(self, low=0.0, high=1.0):
        self.state = (self.state * 6364136223846793005 + 1442695040888963407) % 2**64
        return low + (self.state >> 11) / 2**53 * (high - low)


def planes_around(points):
    """Normals and offsets of the 26-DOP of the points."""
    planes = []
    for d in itertools.product([-1, 0, 1], repeat=3):
        if any(d):
            n = np.array(d) / np.linalg.norm(d)
            planes.append([*map(float, n), float((points @ n).max())])
    return planes


def corners(planes):
    """All points where three planes meet and which no plane cuts off."""
    planes, found = np.array(planes), []
    for three in itertools.combinations(planes, 3):
        three = np.array(three)
        if abs(np.linalg.det(three[:, :3])) > 1e-6:
            p = np.linalg.solve(three[:, :3], three[:, 3])
            if (planes[:, :3] @ p <= planes[:, 3] + 1e-9).all() and not any(np.linalg.norm(p - q) < 1e-9 for q in found):
                found.append(p)
    return np.array(found)


def shape(s):
    kind, v = next(iter(s.items()))
    if kind == "planes":
        hull = coal.BVHModelOBBRSS()
        hull.beginModel(0, 0)
        hull.addVertices(corners(v))
        hull.endModel()
        hull.buildConvexHull(True, "Qt")
        return hull.convex
    make = {"box": lambda x, y, z: coal.Box(2 * x, 2 * y, 2 * z), "cylinder": lambda r, h: coal.Cylinder(r, 2 * h),
            "sphere": coal.Sphere, "capsule": lambda r, h: coal.Capsule(r, 2 * h)}
    return make[kind](*v)


def mesh_bodies(path, packages):
    model = pin.buildModelFromUrdf(path)
    out = []
    for g in pin.buildGeomFromUrdf(model, path, pin.GeometryType.COLLISION, package_dirs=[packages]).geometryObjects:
        frame = model.frames[g.parentFrame]
        if isinstance(g.geometry, coal.Box):
            X_LS = frame.placement.actInv(g.placement)
            out.append({"link": frame.name, "X_LS": pose(X_LS), "shape": {"box": [float(v) for v in g.geometry.halfSide]}})
            continue
        points = np.array(g.geometry.vertices())
        middle = (points.min(axis=0) + points.max(axis=0)) / 2
        X_LS = frame.placement.actInv(g.placement) * pin.SE3(np.eye(3), middle)
        out.append({"link": frame.name, "X_LS": pose(X_LS), "shape": {"planes": planes_around(points - middle)}})
    return out


def primitive_bodies(urdf):
    out = []
    for link in urdf.findall("link"):
        for c in link.findall("collision"):
            g = c.find("geometry")[0]
            r, l = float(g.get("radius", 0)), float(g.get("length", 0)) / 2
            s = {"box": lambda: [float(v) / 2 for v in g.get("size").split()], "sphere": lambda: [r],
                 "cylinder": lambda: [r, l], "capsule": lambda: [r, l]}[g.tag]()
            out.append({"link": link.get("name"), "X_LS": pose(origin(c)), "shape": {g.tag: s}})
    return out


def objects(random, near, far, high):
    out = []
    while len(out) < N_OBJECTS:
        p = np.array([random(-far, far), random(-far, far), random(0, high)])
        q = pin.Quaternion(pin.exp3(np.array([random(-2, 2), random(-2, 2), random(-2, 2)])))
        kind = ["box", "cylinder", "sphere", "capsule"][len(out) % 4]
        s = [random(0.03, 0.2) for _ in range({"box": 3, "sphere": 1}.get(kind, 2))]
        if np.linalg.norm(p[:2]) > near:
            out.append({"X_WS": pose(pin.SE3(q, p)), "shape": {kind: s}})
    return out


def se3(v):
    return pin.SE3(pin.Quaternion(np.array(v[3:])), np.array(v[:3]))


def robot(name, text, bodies, things, seed):
    urdf = ET.fromstring(text)
    whole = tree(urdf, {l.get("name") for l in urdf.findall("link")})
    model = pin.buildModelFromXML(text)
    geometry = pin.GeometryModel()
    for i, b in enumerate(bodies):
        frame = model.getFrameId(b["link"])
        X = model.frames[frame].placement * se3(b["X_LS"])
        geometry.addGeometryObject(pin.GeometryObject(f"b{i}", model.frames[frame].parentJoint, frame, X, shape(b["shape"])))
    for j, o in enumerate(things):
        geometry.addGeometryObject(pin.GeometryObject(f"o{j}", 0, 0, se3(o["X_WS"]), shape(o["shape"])))
    random = Random(seed)

    def draw():
        full = pin.neutral(model)
        values = [random(-math.pi, math.pi) if d["lower"] is None else random(d["lower"], d["upper"]) for d in whole["dofs"]]
        for joint in whole["joints"]:
            if joint["drive"]:
                dof, scale, offset = joint["drive"]
                value = values[dof] * scale + offset
                j = model.joints[model.getJointId(joint["name"])]
                if j.nq == 2:
                    full[j.idx_q], full[j.idx_q + 1] = math.cos(value), math.sin(value)
                else:
                    full[j.idx_q] = value
        return full

    # Pairs that count: of links that some joint moves against each other, not neighbours, not touching in nearly all configurations.
    joint_of = [geometry.geometryObjects[i].parentJoint for i in range(len(bodies))]
    near = lambda a, b: joint_of[a] == joint_of[b] or model.parents[joint_of[a]] == joint_of[b] or model.parents[joint_of[b]] == joint_of[a]
    pairs = [[a, b] for a in range(len(bodies)) for b in range(a + 1, len(bodies)) if not near(a, b)]
    data = model.createData()

    def with_pairs(pairs, n):
        geometry.removeAllCollisionPairs()
        for a, b in pairs:
            geometry.addCollisionPair(pin.CollisionPair(a, b))
        found = pin.GeometryData(geometry)
        for _ in range(n):
            q = draw()
            hit = pin.computeCollisions(model, data, geometry, found, q, n == N)
            yield hit, found, q

    touching = np.zeros(len(pairs))
    for _, found, _ in with_pairs(pairs, 300):
        touching += [r.isCollision() for r in found.collisionResults]
    pairs = [p for p, n in zip(pairs, touching) if n < 290]
    outer = [[i, len(bodies) + j] for i in range(len(bodies)) if joint_of[i] != 0 for j in range(len(things))]
    start = random.state
    hits, overruled = [], []
    for hit, found, q in with_pairs(pairs + outer, N):
        # What coal calls free although its own signed distance says that two bodies overlap counts as hit.
        if not hit:
            pin.computeDistances(model, data, geometry, found, q)
            if min(r.min_distance for r in found.distanceResults) < -1e-6:
                hit = True
                overruled.append(len(hits))
        hits.append(hit)
    bits = "".join("%x" % sum(h << k for k, h in enumerate(hits[i : i + 4])) for i in range(0, N, 4))
    print(name, "overruled:", overruled, "hit:", sum(hits), "pairs:", len(pairs), len(outer), file=sys.stderr)
    return {"name": name, "tree": whole, "bodies": bodies, "objects": things, "pairs": pairs, "state": str(start), "hits": bits, "overruled": overruled}


def main():
    panda, packages, pr2 = sys.argv[1:]
    random = Random(5)
    robots = [
        robot("Panda, 26-DOPs of its meshes", open(panda).read(), mesh_bodies(panda, packages), objects(random, 0.25, 0.8, 1.0), 6),
        robot("PR2 of primitives", open(pr2).read(), primitive_bodies(ET.parse(pr2)), objects(random, 0.6, 1.1, 1.6), 7),
    ]
    json.dump({"tool": "coal", "version": coal.__version__, "robots": robots}, sys.stdout, separators=(",", ":"))
    print()


main()
