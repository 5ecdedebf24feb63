//! Reads the language's notation of values back: `NULL`, `3`, `"red"`, `CUP`, `[CUP, BOX]`, and of ground tasks.
//!
//! The inverse of `ir::Domain::show`, written apart from the parser so that both must agree. Knows no expressions.

use std::sync::Arc;

use super::fault::{Checked, Kind};
use crate::ir::{Base, Domain, EntitySet, Goal, Param, ScalarSet, StringId, TaskId, Value};

/// Returns the value that `text` writes for a parameter.
pub(super) fn argument(domain: &Domain, param: &Param, text: &str) -> Checked<Value> {
    let wrong = || Kind::Argument {
        text: text.to_owned(),
        expected: format!("{} (parameter `{}`)", expected(domain, param), param.name),
    };
    let value = if param.is_set {
        set(domain, param.base, text).ok_or_else(wrong)?
    } else {
        atom(domain, text).ok_or_else(wrong)?
    };
    if has_type(domain, &value, param) {
        Ok(value)
    } else {
        Err(wrong().into())
    }
}

/// Returns the task of that name and its arguments.
pub(super) fn task(domain: &Domain, name: &str, arguments: &[impl AsRef<str>]) -> Checked<Goal> {
    let task = domain.task(name).ok_or_else(|| Kind::UnknownName {
        what: "task",
        name: name.to_owned(),
    })?;
    let params = domain.task_params(task);
    if params.len() != arguments.len() {
        return Err(Kind::ArgumentCount {
            task: name.to_owned(),
            expected: params.len(),
            found: arguments.len(),
        }
        .into());
    }
    let args = params
        .iter()
        .zip(arguments)
        .map(|(p, text)| argument(domain, p, text.as_ref()))
        .collect::<Checked<Vec<Value>>>()?;
    Ok(Goal { task, args })
}

/// Returns the task that `text`, `MoveObjs(PR2, [A, B])`, names.
pub(super) fn task_text(domain: &Domain, text: &str) -> Checked<Goal> {
    let text = text.trim();
    let malformed = || Kind::Argument {
        text: text.to_owned(),
        expected: "a task with its arguments".to_owned(),
    };
    let (name, rest) = text.split_once('(').ok_or_else(malformed)?;
    let inner = rest.strip_suffix(')').ok_or_else(malformed)?;
    task(domain, name.trim(), &split(inner, ','))
}

/// Returns the task as the language writes it.
pub(super) fn show_task(domain: &Domain, task: TaskId, args: &[Value]) -> String {
    domain.show_task(task, args)
}

/// Splits at the marks that are outside brackets and strings; of an empty text there are no parts.
pub(super) fn split(text: &str, mark: char) -> Vec<String> {
    let mut parts = Vec::new();
    let mut part = String::new();
    let (mut depth, mut quoted, mut escaped) = (0_usize, false, false);
    for c in text.chars() {
        match c {
            _ if escaped => escaped = false,
            '\\' if quoted => escaped = true,
            '"' => quoted = !quoted,
            '[' | '(' if !quoted => depth += 1,
            ']' | ')' if !quoted => depth = depth.saturating_sub(1),
            _ if c == mark && !quoted && depth == 0 => {
                parts.push(std::mem::take(&mut part).trim().to_owned());
                continue;
            }
            _ => {}
        }
        part.push(c);
    }
    if !part.trim().is_empty() || !parts.is_empty() {
        parts.push(part.trim().to_owned());
    }
    parts
}

fn set(domain: &Domain, base: Base, text: &str) -> Option<Value> {
    let inner = text.trim().strip_prefix('[')?.strip_suffix(']')?;
    if let Base::Entity(_) = base {
        let members: Option<EntitySet> = split(inner, ',').iter().map(|name| domain.entity(name)).collect();
        return Some(Value::Set(Arc::new(members?)));
    }
    let mut members = ScalarSet::default();
    for member in split(inner, ',') {
        members.insert(atom(domain, &member)?);
    }
    Some(Value::Scalars(Arc::new(members)))
}

fn atom(domain: &Domain, text: &str) -> Option<Value> {
    match text {
        "true" => Some(Value::Bool(true)),
        "false" => Some(Value::Bool(false)),
        _ if text.starts_with('"') => {
            let position = domain.strings.iter().position(|s| format!("{s:?}") == text)?;
            Some(Value::String(StringId(position as u32)))
        }
        _ => match domain.entity(text) {
            Some(e) => Some(Value::Entity(e)),
            None => text.parse().ok().filter(|x: &f64| x.is_finite()).map(Value::Number),
        },
    }
}

fn has_type(domain: &Domain, value: &Value, param: &Param) -> bool {
    let is_a = |e: crate::ir::EntityId, base: Base| match base {
        Base::Entity(ty) => domain.is_subtype(domain.entities[e.index()].ty, ty),
        Base::Number | Base::Bool | Base::String => false,
    };
    match value {
        Value::Null | Value::Unknown => false,
        Value::Bool(_) => param.base == Base::Bool,
        Value::Number(_) => param.base == Base::Number,
        Value::String(_) => param.base == Base::String,
        Value::Entity(e) => is_a(*e, param.base),
        Value::Set(s) => s.iter().all(|e| is_a(e, param.base)),
        Value::Scalars(s) => s.iter().all(|v| has_type(domain, v, param)),
    }
}

fn expected(domain: &Domain, param: &Param) -> String {
    let base = match param.base {
        Base::Number => "a number",
        Base::Bool => "true or false",
        Base::String => "a string of the domain",
        Base::Entity(ty) => &domain.types[ty.index()].name,
    };
    match param.base {
        Base::Entity(_) if param.is_set => format!("a list of entities of type `{base}`"),
        Base::Entity(_) => format!("an entity of type `{base}`"),
        Base::Number | Base::Bool | Base::String if param.is_set => format!("a list, each {base}"),
        Base::Number | Base::Bool | Base::String => base.to_owned(),
    }
}
