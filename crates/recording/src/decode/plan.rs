//! From paths and a type to what has to be done with each message, worked out once.
//!
//! A plan follows the fields of the type in their order up to the last one that is needed; what lies
//! between is passed over ([`Skip`]). An element chosen by the array beside it needs the place that
//! is found there; where that array comes later, the field is marked and read afterwards.

use std::collections::BTreeMap;

use super::ValueKind;
use super::path::{FieldPath, Key, PathError, Step};
use super::skip::{Items, Layout, Skip, Skips, joined};
use crate::schema::{MessageType, Primitive, Type};

/// What to do with a value.
#[derive(Debug, Clone)]
pub(crate) enum Node {
    Number(Primitive, Vec<usize>),
    Text(Vec<usize>),
    Struct(StructPlan),
    Items(Box<ItemsPlan>),
}

/// What to do with a message: the steps; then, if its end is needed, the rest; then marked fields.
#[derive(Debug, Clone)]
pub(crate) struct StructPlan {
    pub(crate) steps: Vec<PlanStep>,
    pub(crate) rest: Skip,
    pub(crate) deferred: Vec<(usize, Node)>,
}

#[derive(Debug, Clone)]
pub(crate) enum PlanStep {
    Skip(Skip),
    Mark(usize),
    Visit(Node),
}

/// What to do with an array.
#[derive(Debug, Clone)]
pub(crate) struct ItemsPlan {
    pub(crate) items: Items,
    /// Slots that take the number of elements.
    pub(crate) lengths: Vec<usize>,
    pub(crate) picks: Vec<(Pick, Node)>,
    pub(crate) finds: Vec<Find>,
    pub(crate) wheres: Vec<Where>,
}

/// Which element.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Pick {
    Index(u64),
    /// The one whose place was found in an array beside this.
    Place(usize),
}

/// Finds the place of the first element that equals a key.
#[derive(Debug, Clone)]
pub(crate) struct Find {
    pub(crate) place: usize,
    pub(crate) slot: usize,
    pub(crate) key: Key,
    pub(crate) node: Node,
}

/// Finds the first element whose parts equal keys, and reads it.
#[derive(Debug, Clone)]
pub(crate) struct Where {
    pub(crate) keys: Node,
    pub(crate) tests: Vec<(usize, Key)>,
    pub(crate) then: Node,
}

/// A plan for one layout.
#[derive(Debug, Clone)]
pub(crate) struct Plan {
    pub(crate) root: StructPlan,
    pub(crate) slots: usize,
    pub(crate) places: usize,
    pub(crate) marks: usize,
    pub(crate) kinds: Vec<ValueKind>,
}

/// A part of a path that is still to be followed.
#[derive(Clone)]
struct Request<'p> {
    path: &'p FieldPath,
    steps: &'p [Step],
    slot: usize,
    is_length: bool,
    role: Role<'p>,
}

#[derive(Clone)]
enum Role<'p> {
    Read,
    /// Read the element at a place.
    ReadAt(usize),
    /// Find the place of a key.
    Find(usize, &'p Key),
}

pub(crate) fn plan(
    message: &MessageType,
    paths: &[FieldPath],
    layout: Layout,
) -> Result<Plan, PathError> {
    let mut planner = Planner {
        layout,
        skips: Skips::new(layout),
        slots: paths.len(),
        places: 0,
        marks: 0,
        kinds: vec![ValueKind::Unknown; paths.len()],
    };
    let requests = paths.iter().enumerate().map(|(slot, path)| Request {
        path,
        steps: &path.steps,
        slot,
        is_length: path.is_length,
        role: Role::Read,
    });
    let root = planner.structure(message, requests.collect())?;
    planner.kinds.truncate(paths.len());
    Ok(Plan {
        root,
        slots: planner.slots,
        places: planner.places,
        marks: planner.marks,
        kinds: planner.kinds,
    })
}

struct Planner {
    layout: Layout,
    skips: Skips,
    slots: usize,
    places: usize,
    marks: usize,
    kinds: Vec<ValueKind>,
}

/// Requests by field: those served in passing, and those that wait for an array further on.
#[derive(Default)]
struct ByField<'p> {
    now: BTreeMap<usize, Vec<Request<'p>>>,
    late: BTreeMap<usize, Vec<Request<'p>>>,
}

impl Planner {
    fn new_slot(&mut self) -> usize {
        self.kinds.push(ValueKind::Unknown);
        self.slots += 1;
        self.slots - 1
    }

    fn structure<'p>(
        &mut self,
        message: &MessageType,
        requests: Vec<Request<'p>>,
    ) -> Result<StructPlan, PathError> {
        let by_field = self.sort(message, requests)?;
        let ByField { mut now, late } = by_field;
        let needed = now
            .keys()
            .chain(late.keys())
            .max()
            .map_or(0, |last| last + 1);
        let (mut steps, mut deferred, mut pending) = (Vec::new(), Vec::new(), Vec::new());
        let mut hidden_by: Option<&str> = None;
        for (index, field) in message.fields.iter().enumerate().take(needed) {
            let requests = now.remove(&index);
            let waiting = late.get(&index);
            if let Some(request) = waiting.or(requests.as_ref()).and_then(|all| all.first())
                && let Some(hidden_by) = hidden_by
            {
                return Err(request.path.error(unreadable(hidden_by)));
            }
            if !pending.is_empty() && (requests.is_some() || waiting.is_some()) {
                steps.push(PlanStep::Skip(joined(std::mem::take(&mut pending))));
            }
            if let Some(waiting) = waiting {
                steps.push(PlanStep::Mark(self.marks));
                let mark = self.marks;
                self.marks += 1;
                deferred.push((mark, self.node(&field.kind, waiting.clone())?));
            }
            let skip = self.skips.of(&field.kind);
            if !skip.is_readable() {
                hidden_by = Some(&field.name);
            }
            match requests {
                Some(requests) => steps.push(PlanStep::Visit(self.node(&field.kind, requests)?)),
                None => pending.push(skip),
            }
        }
        if !pending.is_empty() {
            steps.push(PlanStep::Skip(joined(pending)));
        }
        let rest = message.fields.iter().skip(needed);
        let rest = joined(rest.map(|field| self.skips.of(&field.kind)).collect());
        Ok(StructPlan {
            steps,
            rest,
            deferred,
        })
    }

    /// Finds the field that each request is about.
    fn sort<'p>(
        &mut self,
        message: &MessageType,
        requests: Vec<Request<'p>>,
    ) -> Result<ByField<'p>, PathError> {
        let mut by_field = ByField::default();
        for mut request in requests {
            let path = request.path;
            let Some((Step::Field(name), rest)) = request.steps.split_first() else {
                return Err(path.error(format!(
                    "it leads to a message of type {}; {}",
                    message.name,
                    name_one_of(message)
                )));
            };
            let Some((index, field)) = message.field(name) else {
                return Err(path.error(format!(
                    "{} has no field {name}; {}",
                    message.name,
                    name_one_of(message)
                )));
            };
            request.steps = rest;
            let beside = beside(message, &field.kind, rest).map_err(|m| path.error(m))?;
            let Some((other, key)) = beside else {
                by_field.now.entry(index).or_default().push(request);
                continue;
            };
            let (place, slot) = (self.places, self.new_slot());
            self.places += 1;
            let find = Request {
                path,
                steps: &[],
                slot,
                is_length: false,
                role: Role::Find(place, key),
            };
            by_field.now.entry(other).or_default().push(find);
            request.steps = &rest[1..];
            request.role = Role::ReadAt(place);
            let when = if other < index {
                &mut by_field.now
            } else {
                &mut by_field.late
            };
            when.entry(index).or_default().push(request);
        }
        Ok(by_field)
    }

    fn node(&mut self, kind: &Type, requests: Vec<Request<'_>>) -> Result<Node, PathError> {
        let path = requests[0].path;
        if !self.layout.reads(kind) {
            return Err(path.error(unreadable("it")));
        }
        match kind {
            Type::Primitive(primitive) => {
                let slots = self.leaves(&requests, ValueKind::of(*primitive))?;
                Ok(Node::Number(*primitive, slots))
            }
            Type::Text | Type::WideText => Ok(Node::Text(self.leaves(&requests, ValueKind::Text)?)),
            Type::Struct(message) => {
                if let Some(request) = requests.iter().find(|r| r.is_length && r.steps.is_empty()) {
                    return Err(request.path.error("only arrays have a length"));
                }
                Ok(Node::Struct(self.structure(message, requests)?))
            }
            Type::Array(element, count) => self.items(element, Some(*count), requests),
            Type::Sequence(element) => self.items(element, None, requests),
        }
    }

    /// The slots of requests that end here.
    fn leaves(
        &mut self,
        requests: &[Request<'_>],
        kind: ValueKind,
    ) -> Result<Vec<usize>, PathError> {
        for request in requests {
            if !request.steps.is_empty() {
                let problem = format!("{kind} has no parts; end the path before it");
                return Err(request.path.error(problem));
            }
            if request.is_length {
                return Err(request.path.error("only arrays have a length"));
            }
            self.kinds[request.slot] = kind;
        }
        Ok(requests.iter().map(|request| request.slot).collect())
    }

    fn items(
        &mut self,
        element: &Type,
        count: Option<u64>,
        requests: Vec<Request<'_>>,
    ) -> Result<Node, PathError> {
        let items = self.skips.items(element, count);
        if !items.element.is_readable() {
            return Err(requests[0].path.error(unreadable("it")));
        }
        let mut plan = ItemsPlan {
            items,
            lengths: Vec::new(),
            picks: Vec::new(),
            finds: Vec::new(),
            wheres: Vec::new(),
        };
        for request in requests {
            self.item(element, request, &mut plan)?;
        }
        Ok(Node::Items(Box::new(plan)))
    }

    fn item(
        &mut self,
        element: &Type,
        mut request: Request<'_>,
        plan: &mut ItemsPlan,
    ) -> Result<(), PathError> {
        match std::mem::replace(&mut request.role, Role::Read) {
            Role::Find(place, key) => {
                let slot = request.slot;
                let node = self.node(element, vec![request])?;
                plan.finds.push(Find {
                    place,
                    slot,
                    key: key.clone(),
                    node,
                });
                return Ok(());
            }
            Role::ReadAt(place) => {
                let node = self.node(element, vec![request])?;
                plan.picks.push((Pick::Place(place), node));
                return Ok(());
            }
            Role::Read => {}
        }
        let Some((step, rest)) = request.steps.split_first() else {
            if request.is_length {
                self.kinds[request.slot] = ValueKind::Length;
                plan.lengths.push(request.slot);
                return Ok(());
            }
            let problem = "it is an array; give an index, as in a[0], or ask for length(a)";
            return Err(request.path.error(problem));
        };
        request.steps = rest;
        match step {
            Step::Index(index) => {
                let node = self.node(element, vec![request])?;
                plan.picks.push((Pick::Index(*index), node));
                Ok(())
            }
            Step::Where(conditions) => {
                let (mut tests, mut wanted) = (Vec::new(), Vec::new());
                let mut steps = Vec::new();
                for condition in conditions {
                    let names = condition.names.iter().cloned().map(Step::Field);
                    steps.push(names.collect::<Vec<Step>>());
                }
                for (condition, steps) in conditions.iter().zip(&steps) {
                    let slot = self.new_slot();
                    tests.push((slot, condition.key.clone()));
                    wanted.push(Request {
                        path: request.path,
                        steps,
                        slot,
                        is_length: false,
                        role: Role::Read,
                    });
                }
                let keys = self.node(element, wanted)?;
                let then = self.node(element, vec![request])?;
                plan.wheres.push(Where { keys, tests, then });
                Ok(())
            }
            Step::Field(name) => {
                let problem = format!("it is an array; give an index before .{name}");
                Err(request.path.error(problem))
            }
        }
    }
}

fn unreadable(name: &str) -> String {
    format!(
        "it stands in or behind wide text or a table ({name}) whose layout differs between \
         implementations, so it cannot be read"
    )
}

fn name_one_of(message: &MessageType) -> String {
    let names: Vec<&str> = message
        .fields
        .iter()
        .map(|f| f.name.as_str())
        .take(30)
        .collect();
    if names.is_empty() {
        "it has no fields".to_owned()
    } else {
        format!("name one of its fields: {}", names.join(", "))
    }
}

/// For a step `[name='value']` on an array whose elements have no such part: the field `name` of
/// the message, which must be an array too, and the value.
fn beside<'p>(
    message: &MessageType,
    kind: &Type,
    steps: &'p [Step],
) -> Result<Option<(usize, &'p Key)>, String> {
    let (Some(Step::Where(conditions)), Type::Array(element, _) | Type::Sequence(element)) =
        (steps.first(), kind)
    else {
        return Ok(None);
    };
    let first = &conditions[0].names[0];
    if let Type::Struct(inner) = &**element
        && inner.field(first).is_some()
    {
        return Ok(None);
    }
    let field = message.field(first);
    let Some((index, other)) = field.filter(|_| conditions.len() == 1) else {
        return Err(format!(
            "neither its elements nor {} have {first}",
            message.name
        ));
    };
    let is_simple = conditions[0].names.len() == 1;
    let is_list = matches!(&other.kind, Type::Array(inner, _) | Type::Sequence(inner)
        if matches!(**inner, Type::Text | Type::Primitive(_)));
    if !is_simple || !is_list {
        return Err(format!(
            "{first} is not an array of texts or numbers beside it"
        ));
    }
    Ok(Some((index, &conditions[0].key)))
}
