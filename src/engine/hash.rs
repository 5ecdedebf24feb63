//! Fingerprints of 128 bits for states and remaining tasks.
//!
//! Two different things get the same fingerprint with a probability of 2^-128 a pair: the tables of `memo` count that as
//! never. Two lanes of multiply and shift (the finaliser of SplitMix64: Steele, Lea and Flood, OOPSLA 2014,
//! doi:10.1145/2660193.2660195); the same on every machine, and no secret.

use crate::ir::Value;

/// A running fingerprint.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) struct Print {
    a: u64,
    b: u64,
}

impl Print {
    /// Returns the print of a number alone.
    pub fn of(x: u64) -> Print {
        Print::default().number(x)
    }

    /// Adds a number.
    pub fn number(self, x: u64) -> Print {
        Print {
            a: finish((self.a ^ x).wrapping_add(0x9e37_79b9_7f4a_7c15)),
            b: finish((self.b.rotate_left(23) ^ x).wrapping_mul(0xd6e8_feb8_6659_fd93)),
        }
    }

    /// Adds another print.
    pub fn print(self, other: Print) -> Print {
        self.number(other.a).number(other.b)
    }

    /// Adds a value. Equal values have equal prints.
    pub fn value(self, value: &Value) -> Print {
        match value {
            Value::Null => self.number(0),
            // What no other value begins with: entities are 4 modulo 8.
            Value::Unknown => self.number(6),
            Value::Bool(b) => self.number(1).number(u64::from(*b)),
            // -0 is 0.
            Value::Number(x) => self.number(2).number((x + 0.0).to_bits()),
            Value::String(s) => self.number(3).number(u64::from(s.0)),
            Value::Entity(e) => self.number(4 + (u64::from(e.0) << 3)),
            Value::Set(set) => set
                .iter()
                .fold(self.number(5), |print, e| print.number(1 + u64::from(e.0))),
            // An empty set is the same whatever it could hold.
            Value::Scalars(set) => set.iter().fold(self.number(5), Print::value),
        }
    }

    /// Adds or takes away a member of a collection without order.
    pub fn toggle(self, member: Print) -> Print {
        Print {
            a: self.a ^ member.a,
            b: self.b ^ member.b,
        }
    }

    /// Adds a member of a collection without order, in which a member may be twice.
    pub fn with(self, member: Print) -> Print {
        Print {
            a: self.a.wrapping_add(member.a),
            b: self.b.wrapping_add(member.b),
        }
    }

    /// Returns the print as one number.
    pub fn key(self) -> u128 {
        u128::from(self.a) << 64 | u128::from(self.b)
    }
}

fn finish(mut x: u64) -> u64 {
    x = (x ^ x >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    x = (x ^ x >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
    x ^ x >> 31
}
