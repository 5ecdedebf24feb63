//! Fingerprints of world states and calls: keys of what is remembered, and of random streams.
//!
//! FNV-1a (Fowler, Noll, Vo; 64 bits): its definition never changes, unlike the standard library's hasher.

use crate::geom::Pose;
use crate::world::State;

/// A running fingerprint.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub(super) struct Key(pub u64);

impl Key {
    /// Starts from a seed.
    pub(super) fn new(seed: u64) -> Key {
        Key(0xcbf2_9ce4_8422_2325).number(seed)
    }

    /// Adds eight bytes.
    pub(super) fn number(mut self, n: u64) -> Key {
        for byte in n.to_le_bytes() {
            self.0 = (self.0 ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01b3);
        }
        self
    }

    /// Adds a text and its length.
    pub(super) fn text(mut self, text: &str) -> Key {
        for byte in text.bytes() {
            self.0 = (self.0 ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01b3);
        }
        self.number(text.len() as u64)
    }

    fn pose(self, pose: &Pose) -> Key {
        let (t, r) = (pose.translation.vector, pose.rotation.coords);
        [t.x, t.y, t.z, r.x, r.y, r.z, r.w]
            .iter()
            .fold(self, |k, x| k.number(x.to_bits()))
    }

    /// Adds everything that a world state is made of, to the last bit.
    pub(super) fn state(self, state: &State) -> Key {
        let mut key = self;
        for agent in &state.agents {
            key = agent.q.iter().fold(key.pose(&agent.X_WB), |k, x| k.number(x.to_bits()));
        }
        for object in &state.objects {
            key = key.pose(&object.X_WO);
            key = match &object.held {
                None => key.number(0),
                Some(h) => key.number(1 + h.agent as u64).number(h.arm as u64).pose(&h.X_TO),
            };
        }
        key
    }
}
