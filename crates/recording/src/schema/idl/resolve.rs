//! From what is written in IDL to types: names are looked up, and what they stand for is put in.

use std::collections::BTreeMap;
use std::sync::Arc;

use super::{Base, DEPTH_LIMIT, Defined, Written};
use crate::schema::SchemaError;
use crate::schema::message_type::{Constant, MessageField, MessageType, Primitive, Type};

pub(super) struct Resolver<'d> {
    pub(super) defined: &'d BTreeMap<String, Defined>,
    pub(super) known: BTreeMap<String, Arc<MessageType>>,
}

impl<'d> Resolver<'d> {
    pub(super) fn structure(
        &mut self,
        name: &str,
        depth: usize,
    ) -> Result<Arc<MessageType>, SchemaError> {
        if let Some(done) = self.known.get(name) {
            return Ok(done.clone());
        }
        let Some(Defined::Struct(members)) = self.defined.get(name) else {
            return Err(SchemaError::new(0, format!("{name} is not a structure")));
        };
        let mut made = MessageType {
            name: name.replace("::", "/"),
            fields: Vec::new(),
            constants: Vec::new(),
        };
        for (member, written) in members {
            self.constants_of(written, &mut made.constants);
            made.fields.push(MessageField {
                name: member.clone(),
                kind: self.kind(written, depth + 1)?,
            });
        }
        let made = Arc::new(made);
        self.known.insert(name.to_owned(), made.clone());
        Ok(made)
    }

    fn kind(&mut self, written: &Written, depth: usize) -> Result<Type, SchemaError> {
        if depth > DEPTH_LIMIT {
            let problem = "types are nested too deeply, or one contains itself";
            return Err(SchemaError::new(written.line, problem));
        }
        let mut kind = match &written.base {
            Base::Plain(kind) => kind.clone(),
            Base::Sequence(element) => Type::Sequence(Box::new(self.kind(element, depth + 1)?)),
            Base::Named(name) => match self.find(name, &written.scope) {
                Some((full, Defined::Struct(_))) => Type::Struct(self.structure(&full, depth + 1)?),
                Some((_, Defined::Alias(other))) => self.kind(other, depth + 1)?,
                Some((_, Defined::Enumeration(_))) => Type::Primitive(Primitive::Uint32),
                None => {
                    let problem = format!("the type {name} is used, but not defined");
                    return Err(SchemaError::new(written.line, problem));
                }
            },
        };
        for length in written.dimensions.iter().rev() {
            kind = Type::Array(Box::new(kind), *length);
        }
        Ok(kind)
    }

    /// The numbers behind the names of an enumeration are told as constants.
    fn constants_of(&self, written: &Written, constants: &mut Vec<Constant>) {
        let Base::Named(name) = &written.base else {
            return;
        };
        let Some((full, Defined::Enumeration(names))) = self.find(name, &written.scope) else {
            return;
        };
        for (value, name) in names.iter().enumerate() {
            constants.push(Constant {
                name: name.clone(),
                type_name: full.clone(),
                value: value.to_string(),
            });
        }
    }

    /// Looks a name up from the innermost scope outwards.
    fn find(&self, name: &str, scope: &[String]) -> Option<(String, &'d Defined)> {
        let name = name.trim_start_matches("::");
        (0..=scope.len()).rev().find_map(|depth| {
            let mut parts = scope[..depth].to_vec();
            parts.push(name.to_owned());
            let full = parts.join("::");
            self.defined.get(&full).map(|found| (full, found))
        })
    }
}
