//! An element of a list that is written as a word, or as a table where a word does not say enough.

use std::fmt::{self, Formatter};
use std::marker::PhantomData;
use std::ops::Deref;

use serde::de::value::MapAccessDeserializer;
use serde::de::{Error, MapAccess, Visitor};
use serde::{Deserialize, Deserializer, Serialize};

/// Written as a table; read from a table or from a word.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(transparent)]
pub struct StringOr<T>(pub T);

impl<T> Deref for StringOr<T> {
    type Target = T;

    fn deref(&self) -> &T {
        &self.0
    }
}

// By hand, because `#[serde(untagged)]` forgets what is wrong inside the table.
impl<'de, T: Deserialize<'de> + From<String>> Deserialize<'de> for StringOr<T> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Either<T>(PhantomData<T>);

        impl<'de, T: Deserialize<'de> + From<String>> Visitor<'de> for Either<T> {
            type Value = T;

            fn expecting(&self, f: &mut Formatter<'_>) -> fmt::Result {
                f.write_str("a string or a table")
            }

            fn visit_str<E: Error>(self, text: &str) -> Result<T, E> {
                Ok(T::from(text.to_owned()))
            }

            fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<T, A::Error> {
                T::deserialize(MapAccessDeserializer::new(map))
            }
        }

        deserializer.deserialize_any(Either(PhantomData)).map(Self)
    }
}
