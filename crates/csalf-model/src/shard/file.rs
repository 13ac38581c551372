//! The file of a shard, version 1. All numbers are little-endian.
//!
//! | bytes | what |
//! |---|---|
//! | 0 to 11 | `csalf-shard` and a line feed |
//! | 12 to 15 | version of the format: 1 |
//! | 16 to 23 | length of the payload |
//! | 24 to 39 | SipHash-2-4 of the payload, 128 bits, key zero |
//! | from 40 | the payload: [`Shard`] in the encoding of postcard 1 (its specification is public) |
//!
//! Floating-point numbers are stored bit for bit.

use super::{MOST_PARTS, Shard, ShardError};
use siphasher::sip128::SipHasher24;

const MAGIC: &[u8; 12] = b"csalf-shard\n";
const VERSION: u32 = 1;
const HEAD: usize = 40;

impl Shard {
    /// The bytes of the file.
    ///
    /// # Errors
    /// [`ShardError::Damaged`], if a part of it cannot be encoded.
    pub fn to_bytes(&self) -> Result<Vec<u8>, ShardError> {
        let damaged =
            |e: postcard::Error| ShardError::Damaged { name: self.name.clone(), what: e.to_string() };
        let payload = postcard::to_stdvec(self).map_err(damaged)?;
        let mut bytes = Vec::with_capacity(HEAD + payload.len());
        bytes.extend(MAGIC);
        bytes.extend(VERSION.to_le_bytes());
        bytes.extend((payload.len() as u64).to_le_bytes());
        bytes.extend(SipHasher24::new().hash(&payload).as_bytes());
        bytes.extend(payload);
        Ok(bytes)
    }

    /// The shard in a file that messages call `name`.
    ///
    /// # Errors
    /// [`ShardError::NotAShard`], [`ShardError::Version`] or [`ShardError::Damaged`].
    pub fn from_bytes(name: &str, bytes: &[u8]) -> Result<Self, ShardError> {
        let name = name.to_owned();
        let damaged = |name: String, what: String| ShardError::Damaged { name, what };
        let Some(rest) = bytes.strip_prefix(MAGIC) else {
            let cut = !bytes.is_empty() && MAGIC.starts_with(bytes);
            return Err(if cut {
                damaged(name, "it is cut off".into())
            } else {
                ShardError::NotAShard { name }
            });
        };
        let (Some(version), Some(length), Some(sum), Some(payload)) =
            (rest.first_chunk::<4>(), rest.get(4..12), rest.get(12..28), rest.get(28..))
        else {
            return Err(damaged(name, "it is cut off".into()));
        };
        let found = u32::from_le_bytes(*version);
        if found != VERSION {
            return Err(ShardError::Version { name, found, known: VERSION });
        }
        let length = u64::from_le_bytes(length.try_into().unwrap_or_default());
        if payload.len() as u64 != length {
            let what = format!("it should hold {length} bytes after its head, and holds {}", payload.len());
            return Err(damaged(name, what));
        }
        if SipHasher24::new().hash(payload).as_bytes() != sum {
            return Err(damaged(name, "its checksum is wrong".into()));
        }
        match postcard::from_bytes::<Self>(payload) {
            Ok(shard) if (1..=shard.count).contains(&shard.index) && shard.count <= MOST_PARTS => {
                Ok(Self { name, ..shard })
            }
            Ok(shard) => Err(damaged(name, format!("it calls itself {} of {}", shard.index, shard.count))),
            Err(e) => Err(damaged(name, e.to_string())),
        }
    }
}
