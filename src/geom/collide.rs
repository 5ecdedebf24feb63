//! Contact, distance and rays between convex shapes: the only user of `parry`.
