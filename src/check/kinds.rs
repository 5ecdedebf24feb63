//! What an expression may be, as the checker sees it.

use crate::ir::{Base, Domain, TypeId};

/// The type of an expression.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
    Number,
    Bool,
    String,
    Entity(TypeId),
    /// An entity of any type; only what the prelude declares takes one.
    Any,
    /// A set; `None` is the empty list, which fits every set.
    Set(Option<Base>),
    Null,
    /// A pair (least, most) [s].
    Duration,
    /// Already reported: fits everything, so that one mistake has one message.
    Unknown,
}

impl Kind {
    /// Returns the kind of an attribute, parameter or variable.
    pub(super) fn of(base: Base, is_set: bool) -> Self {
        match (base, is_set) {
            (_, true) => Kind::Set(Some(base)),
            (Base::Number, false) => Kind::Number,
            (Base::Bool, false) => Kind::Bool,
            (Base::String, false) => Kind::String,
            (Base::Entity(t), false) => Kind::Entity(t),
        }
    }

    /// Returns the kind of a member of a set; the empty list takes any entity.
    pub(super) fn element(of: Option<Base>) -> Self {
        of.map_or(Kind::Any, |base| Kind::of(base, false))
    }

    /// Returns what a set of it would hold; `None` for what no set can hold.
    pub(super) fn base(self) -> Option<Base> {
        match self {
            Kind::Number => Some(Base::Number),
            Kind::Bool => Some(Base::Bool),
            Kind::String => Some(Base::String),
            Kind::Entity(t) => Some(Base::Entity(t)),
            Kind::Any | Kind::Set(_) | Kind::Null | Kind::Duration | Kind::Unknown => None,
        }
    }

    /// Returns what a message calls it.
    pub(super) fn words(self, domain: &Domain) -> String {
        let type_name = |t: TypeId| domain.types.get(t.index()).map_or("?", |t| t.name.as_str());
        match self {
            Kind::Number => "a number".into(),
            Kind::Bool => "a bool".into(),
            Kind::String => "a string".into(),
            Kind::Entity(t) => format!("an entity of type `{}`", type_name(t)),
            Kind::Any => "an entity".into(),
            Kind::Set(Some(Base::Entity(t))) => format!("a set of `{}`", type_name(t)),
            Kind::Set(Some(Base::Number)) => "a set of numbers".into(),
            Kind::Set(Some(Base::Bool)) => "a set of bools".into(),
            Kind::Set(Some(Base::String)) => "a set of strings".into(),
            Kind::Set(None) => "a set".into(),
            Kind::Null => "`NULL`".into(),
            Kind::Duration => "a duration (least, most)".into(),
            Kind::Unknown => "something unknown".into(),
        }
    }

    /// Returns how a parameter of the kind is declared, without its name.
    pub(super) fn declared(self, domain: &Domain) -> String {
        let type_name = |t: TypeId| domain.types.get(t.index()).map_or("?", |t| t.name.as_str());
        match self {
            Kind::Number | Kind::Duration | Kind::Unknown => "number".into(),
            Kind::Bool => "bool".into(),
            Kind::String => "string".into(),
            Kind::Entity(t) => type_name(t).into(),
            Kind::Set(Some(base)) => format!("set {}", Kind::of(base, false).declared(domain)),
            Kind::Any => "any".into(),
            Kind::Set(None) => "set any".into(),
            Kind::Null => "Agent".into(),
        }
    }

    /// Says whether a value of this kind may stand where `wanted` is asked.
    pub(super) fn fits(self, wanted: Kind, domain: &Domain) -> bool {
        match (self, wanted) {
            (Kind::Unknown, _) | (_, Kind::Unknown) => true,
            (Kind::Entity(a), Kind::Entity(b)) => domain.is_subtype(a, b),
            (Kind::Set(Some(a)), Kind::Set(Some(b))) => Kind::of(a, false).fits(Kind::of(b, false), domain),
            (Kind::Entity(_), Kind::Any) | (Kind::Set(_), Kind::Set(None)) | (Kind::Set(None), Kind::Set(_)) => true,
            (a, b) => a == b,
        }
    }

    /// Says whether two values may be compared for equality: one could be the other.
    pub(super) fn comparable(self, other: Kind, domain: &Domain) -> bool {
        match (self, other) {
            (Kind::Set(_), Kind::Null) | (Kind::Null, Kind::Set(_)) => false,
            (Kind::Duration, _) | (_, Kind::Duration) => false,
            (Kind::Null, _) | (_, Kind::Null) => true,
            (a, b) => a.fits(b, domain) || b.fits(a, domain),
        }
    }
}
