// Poses and forward kinematics, in plain numbers: no three.js here.
//
// A pose is {position: [x, y, z], quaternion: [x, y, z, w]} [m], as in the plan document; X_AB is the pose of
// frame B in frame A (docs/notation.md).

const IDENTITY = { position: [0, 0, 0], quaternion: [0, 0, 0, 1] };

/** Returns the product of two quaternions. */
function multiply([ax, ay, az, aw], [bx, by, bz, bw]) {
  return [
    aw * bx + ax * bw + ay * bz - az * by,
    aw * by - ax * bz + ay * bw + az * bx,
    aw * bz + ax * by - ay * bx + az * bw,
    aw * bw - ax * bx - ay * by - az * bz,
  ];
}

/** Returns the vector turned by the unit quaternion. */
function rotate([x, y, z, w], [vx, vy, vz]) {
  const tx = 2 * (y * vz - z * vy);
  const ty = 2 * (z * vx - x * vz);
  const tz = 2 * (x * vy - y * vx);
  return [vx + w * tx + y * tz - z * ty, vy + w * ty + z * tx - x * tz, vz + w * tz + x * ty - y * tx];
}

/** Returns X_AC = X_AB X_BC. */
function compose(X_AB, X_BC) {
  const moved = rotate(X_AB.quaternion, X_BC.position);
  return {
    position: X_AB.position.map((p, i) => p + moved[i]),
    quaternion: multiply(X_AB.quaternion, X_BC.quaternion),
  };
}

/** Returns the pose of a joint's child link in the joint frame, at the joint's value [rad] or [m]. */
function jointMotion(joint, value) {
  const { kind, axis } = joint;
  if (kind === "revolute") {
    const s = Math.sin(value / 2);
    return { position: [0, 0, 0], quaternion: [axis[0] * s, axis[1] * s, axis[2] * s, Math.cos(value / 2)] };
  }
  if (kind === "prismatic") {
    return { position: axis.map((a) => a * value), quaternion: [0, 0, 0, 1] };
  }
  return IDENTITY;
}

/** Returns X_WL of every link L of the agent whose root link is at X_WB, at the configuration q. */
function linkPoses(agent, X_WB, q) {
  const X_WL = [X_WB];
  for (const joint of agent.joints) {
    const value = joint.drive ? q[joint.drive.dof] * joint.drive.scale + joint.drive.offset : 0;
    X_WL.push(compose(compose(X_WL[joint.parent], joint.pose), jointMotion(joint, value)));
  }
  return X_WL;
}
