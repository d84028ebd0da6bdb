//! Values of a TOML file for serde, with messages that speak of the file: its keys, numbers, texts and
//! tables.
//!
//! Lists must be as long as what they are read into: serde's own arrays take what they need and leave the
//! rest.

use super::{hints, unserved};
use crate::counts::counted;
use crate::near::what_there_is;
use crate::state::leaf::{LEAF, is_file};
use serde::de::value::StrDeserializer;
use serde::de::{
    DeserializeSeed, Deserializer, EnumAccess, Error as _, Expected, IntoDeserializer, MapAccess, SeqAccess,
    Unexpected, Visitor,
};
use serde::forward_to_deserialize_any;
use std::fmt;
use std::ops::Range;
use toml::Spanned;
use toml::de::{DeArray, DeTable, DeValue};

/// What is wrong, and where.
#[derive(Debug)]
pub(super) struct Fault {
    /// The key that it is about, outermost table last.
    path: Vec<String>,
    reason: String,
    /// Bytes of the text.
    pub span: Option<Range<usize>>,
    /// Where a key is unknown, those that may stand there.
    expected: &'static [&'static str],
}

impl Fault {
    fn new(reason: String, span: Range<usize>) -> Self {
        Self { path: Vec::new(), reason, span: Some(span), expected: &[] }
    }

    /// This fault, which happened within the value of `key`.
    fn within(mut self, key: &str, span: Range<usize>) -> Self {
        self.path.push(key.to_owned());
        self.at(span)
    }

    /// This fault, which is about `key` before its `value` is read.
    fn of_key(mut self, key: &str, value: &DeValue<'_>) -> Self {
        if let Some(reason) = unserved::of_key(key, value, self.expected) {
            self.reason = reason;
        }
        self
    }

    fn at(mut self, span: Range<usize>) -> Self {
        self.span.get_or_insert(span);
        self
    }
}

impl fmt::Display for Fault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let path: Vec<&str> = self.path.iter().rev().map(String::as_str).collect();
        match &path[..] {
            [] => f.write_str(&self.reason),
            path => write!(f, "{}: {}", path.join("."), self.reason),
        }
    }
}

impl std::error::Error for Fault {}

impl serde::de::Error for Fault {
    fn custom<T: fmt::Display>(reason: T) -> Self {
        Self { path: Vec::new(), reason: reason.to_string(), span: None, expected: &[] }
    }

    fn invalid_type(found: Unexpected<'_>, expected: &dyn Expected) -> Self {
        Self::custom(format!("{found} where {expected} is expected"))
    }

    fn missing_field(field: &'static str) -> Self {
        Self::custom(format!("`{field}` is missing; add it"))
    }

    fn unknown_field(field: &str, expected: &'static [&'static str]) -> Self {
        Self { expected, ..Self::custom(hints::unknown_key(field, expected)) }
    }

    fn unknown_variant(variant: &str, expected: &'static [&'static str]) -> Self {
        Self::custom(format!("no `{}`{}", hints::short(variant), what_there_is(variant, expected)))
    }
}

/// One value.
#[derive(Clone, Copy)]
pub(super) struct Reader<'a, 'de> {
    value: &'a Spanned<DeValue<'de>>,
    /// Its key, empty for the whole file and for members of lists.
    key: &'a str,
    /// The key of the table that it stands in, if the user named it there.
    owner: Option<&'a str>,
    /// Whether it is the whole file.
    whole: bool,
}

impl<'a, 'de> Reader<'a, 'de> {
    /// The whole file.
    pub fn of_document(root: &'a Spanned<DeValue<'de>>) -> Self {
        Self { value: root, key: "", owner: None, whole: true }
    }

    /// The fault that something else than `expected` stands here; `remedy` says what to write, if it is
    /// known.
    fn mismatch(&self, expected: &str, remedy: Option<String>) -> Fault {
        let remedy = remedy.map(|remedy| format!("; {remedy}")).unwrap_or_default();
        Fault::new(
            format!("{} where {expected} is expected{remedy}", hints::found(self.value.get_ref())),
            self.value.span(),
        )
    }

    /// Fails if a texture stands here, where none may.
    fn expect_numbers(&self) -> Result<(), Fault> {
        let refusal = unserved::of_value(self.key, self.value.get_ref());
        refusal.map_or(Ok(()), |reason| Err(Fault::new(reason, self.value.span())))
    }

    fn number(&self) -> Result<f64, Fault> {
        self.expect_numbers()?;
        let number = match self.value.get_ref() {
            DeValue::Float(float) => float.as_str().parse().ok(),
            DeValue::Integer(integer) => {
                i64::from_str_radix(integer.as_str(), integer.radix()).ok().map(|i| i as f64)
            }
            other => return Err(self.mismatch("a number", hints::of_number(other))),
        };
        number.ok_or_else(|| Fault::new("a number beyond all bounds".to_owned(), self.value.span()))
    }

    /// A whole number from 0 on.
    fn count(&self) -> Result<u64, Fault> {
        match self.value.get_ref() {
            DeValue::Integer(integer) => u64::from_str_radix(integer.as_str(), integer.radix())
                .map_err(|_| self.mismatch("a whole number from 0 on", None)),
            other => Err(self.mismatch("a whole number", hints::of_count(other))),
        }
    }

    fn text(&self) -> Result<&'a str, Fault> {
        match self.value.get_ref() {
            DeValue::String(text) => Ok(text),
            other => Err(self.mismatch("a text", hints::of_text(other))),
        }
    }

    fn members(&self, list: &'a DeArray<'de>) -> Members<'a, 'de> {
        Members { rest: list.iter() }
    }

    fn entries(&self, table: &'a DeTable<'de>, owner: Option<&'a str>) -> Entries<'a, 'de> {
        Entries { rest: table.iter(), value: None, owner }
    }
}

impl<'de> Deserializer<'de> for Reader<'_, 'de> {
    type Error = Fault;

    fn deserialize_any<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Fault> {
        let read = match self.value.get_ref() {
            DeValue::String(text) => visitor.visit_str(text),
            DeValue::Boolean(on) => visitor.visit_bool(*on),
            DeValue::Array(list) => visitor.visit_seq(self.members(list)),
            DeValue::Table(table) => visitor.visit_map(self.entries(table, None)),
            DeValue::Integer(_) | DeValue::Float(_) => visitor.visit_f64(self.number()?),
            DeValue::Datetime(_) => Err(self.mismatch("anything but a date", None)),
        };
        read.map_err(|fault| fault.at(self.value.span()))
    }

    fn deserialize_bool<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Fault> {
        match self.value.get_ref() {
            DeValue::Boolean(on) => visitor.visit_bool(*on),
            other => Err(self.mismatch("true or false", hints::of_switch(other))),
        }
    }

    fn deserialize_f32<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Fault> {
        visitor.visit_f64(self.number()?)
    }

    fn deserialize_f64<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Fault> {
        visitor.visit_f64(self.number()?)
    }

    fn deserialize_u32<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Fault> {
        let count = self.count()?;
        let beyond = || Fault::new(format!("{count} is more than {}", u32::MAX), self.value.span());
        visitor.visit_u32(u32::try_from(count).map_err(|_| beyond())?)
    }

    fn deserialize_str<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Fault> {
        visitor.visit_str(self.text()?)
    }

    fn deserialize_string<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Fault> {
        visitor.visit_str(self.text()?)
    }

    fn deserialize_option<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Fault> {
        visitor.visit_some(self)
    }

    fn deserialize_newtype_struct<V: Visitor<'de>>(
        self,
        name: &'static str,
        visitor: V,
    ) -> Result<V::Value, Fault> {
        match self.value.get_ref() {
            DeValue::String(file) if name == LEAF && is_file(file) => visitor.visit_str(file),
            _ if name == LEAF => visitor.visit_some(self),
            _ => visitor.visit_newtype_struct(self),
        }
    }

    /// A list of any length; a list of tables is written as `[[name]]`.
    fn deserialize_seq<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Fault> {
        match self.value.get_ref() {
            DeValue::Array(list) => visitor.visit_seq(self.members(list)),
            DeValue::Table(_) => {
                Err(self
                    .mismatch("a list of tables", Some(format!("write [[{}]], with two brackets", self.key))))
            }
            other => Err(self.mismatch("a list", hints::of_list(other))),
        }
    }

    /// A list of `length` numbers: nothing else in our files has a fixed length.
    fn deserialize_tuple<V: Visitor<'de>>(self, length: usize, visitor: V) -> Result<V::Value, Fault> {
        self.expect_numbers()?;
        match self.value.get_ref() {
            DeValue::Array(list) if list.len() == length => visitor.visit_seq(self.members(list)),
            DeValue::Array(list) => {
                let remedy = hints::of_length(list, length);
                Err(Fault::new(
                    format!(
                        "{} where {length} are expected; {remedy}",
                        counted(list.len(), "number", "numbers")
                    ),
                    self.value.span(),
                ))
            }
            other => {
                let remedy =
                    hints::of_numbers(other, length).map(|remedy| format!("; {remedy}")).unwrap_or_default();
                Err(Fault::new(
                    format!("{} where {length} numbers are expected{remedy}", hints::found(other)),
                    self.value.span(),
                ))
            }
        }
    }

    /// A table whose keys the user chooses.
    fn deserialize_map<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Fault> {
        match self.value.get_ref() {
            DeValue::Table(table) => visitor.visit_map(self.entries(table, Some(self.key))),
            _ => Err(self.mismatch("a table for each name", Some(format!("write [{}.NAME]", self.key)))),
        }
    }

    /// A table of given keys.
    fn deserialize_struct<V: Visitor<'de>>(
        self,
        _: &'static str,
        _: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, Fault> {
        match (self.value.get_ref(), self.owner) {
            // What the whole file lacks is missing nowhere in particular.
            (DeValue::Table(table), _) if self.whole => visitor.visit_map(self.entries(table, None)),
            (DeValue::Table(table), _) => {
                visitor.visit_map(self.entries(table, None)).map_err(|fault| fault.at(self.value.span()))
            }
            (_, Some(owner)) => {
                Err(self.mismatch("a table", Some(format!("write [{owner}.NAME] above the keys"))))
            }
            (DeValue::Array(list), None) if list.iter().all(|member| member.get_ref().is_table()) => {
                Err(self.mismatch("one table", Some(format!("write [{}], with one bracket", self.key))))
            }
            (_, None) => Err(self.mismatch("a table", Some(format!("write [{}] above its keys", self.key)))),
        }
    }

    fn deserialize_enum<V: Visitor<'de>>(
        self,
        _: &'static str,
        _: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, Fault> {
        visitor.visit_enum(Name(self.text()?)).map_err(|fault| fault.at(self.value.span()))
    }

    forward_to_deserialize_any! {
        i8 i16 i32 i64 i128 u8 u16 u64 u128 char bytes byte_buf unit unit_struct tuple_struct identifier ignored_any
    }
}

/// One of a few names.
struct Name<'a>(&'a str);

impl<'a, 'de> EnumAccess<'de> for Name<'a> {
    type Error = Fault;
    type Variant = <StrDeserializer<'a, Fault> as EnumAccess<'de>>::Variant;

    fn variant_seed<V: DeserializeSeed<'de>>(self, seed: V) -> Result<(V::Value, Self::Variant), Fault> {
        let name: StrDeserializer<'a, Fault> = self.0.into_deserializer();
        name.variant_seed(seed)
    }
}

struct Members<'a, 'de> {
    rest: std::slice::Iter<'a, Spanned<DeValue<'de>>>,
}

impl<'de> SeqAccess<'de> for Members<'_, 'de> {
    type Error = Fault;

    fn next_element_seed<T: DeserializeSeed<'de>>(&mut self, seed: T) -> Result<Option<T::Value>, Fault> {
        let read = |value| {
            seed.deserialize(Reader { value, key: "", owner: None, whole: false })
                .map_err(|fault| fault.at(value.span()))
        };
        self.rest.next().map(read).transpose()
    }
}

struct Entries<'a, 'de> {
    rest: toml::map::Iter<'a, Spanned<std::borrow::Cow<'de, str>>, Spanned<DeValue<'de>>>,
    value: Option<(&'a str, &'a Spanned<DeValue<'de>>)>,
    owner: Option<&'a str>,
}

impl<'de> MapAccess<'de> for Entries<'_, 'de> {
    type Error = Fault;

    fn next_key_seed<K: DeserializeSeed<'de>>(&mut self, seed: K) -> Result<Option<K::Value>, Fault> {
        let Some((key, value)) = self.rest.next() else { return Ok(None) };
        self.value = Some((key.get_ref(), value));
        let name: StrDeserializer<'_, Fault> = key.get_ref().as_ref().into_deserializer();
        seed.deserialize(name)
            .map(Some)
            .map_err(|fault| fault.of_key(key.get_ref(), value.get_ref()).at(key.span()))
    }

    fn next_value_seed<V: DeserializeSeed<'de>>(&mut self, seed: V) -> Result<V::Value, Fault> {
        let (key, value) = self.value.take().ok_or_else(|| Fault::custom("a value without a key"))?;
        seed.deserialize(Reader { value, key, owner: self.owner, whole: false })
            .map_err(|fault| fault.within(key, value.span()))
    }
}
