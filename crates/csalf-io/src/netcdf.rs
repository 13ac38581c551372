//! Classic netCDF files with 64-bit offsets, written. Source: *NetCDF Classic Format Specification*, Unidata.
//!
//! ```text
//!   CDF 2 | records | dimensions | attributes | variables (name, type, where its data begin) | data ...
//! ```
//!
//! All numbers are big-endian; names, attributes and data are padded to four bytes.

use crate::IoError;
use std::io::Write;

/// Values of a variable or an attribute.
#[derive(Debug)]
pub(crate) enum Values {
    Text(Vec<u8>),
    Int(Vec<i32>),
    Float(Vec<f32>),
    Double(Vec<f64>),
}

impl Values {
    fn kind(&self) -> u32 {
        match self {
            Self::Text(_) => 2,
            Self::Int(_) => 4,
            Self::Float(_) => 5,
            Self::Double(_) => 6,
        }
    }

    fn len(&self) -> usize {
        match self {
            Self::Text(v) => v.len(),
            Self::Int(v) => v.len(),
            Self::Float(v) => v.len(),
            Self::Double(v) => v.len(),
        }
    }

    /// Bytes with padding.
    fn size(&self) -> u64 {
        let one = match self {
            Self::Text(_) => 1,
            Self::Int(_) | Self::Float(_) => 4,
            Self::Double(_) => 8,
        };
        (self.len() as u64 * one).next_multiple_of(4)
    }

    fn write(&self, w: &mut dyn Write) -> Result<(), IoError> {
        match self {
            Self::Text(v) => {
                w.write_all(v)?;
                w.write_all(&[0; 3][..(4 - v.len() % 4) % 4])?;
            }
            Self::Int(v) => v.iter().try_for_each(|x| w.write_all(&x.to_be_bytes()))?,
            Self::Float(v) => v.iter().try_for_each(|x| w.write_all(&x.to_be_bytes()))?,
            Self::Double(v) => v.iter().try_for_each(|x| w.write_all(&x.to_be_bytes()))?,
        }
        Ok(())
    }
}

/// A file that is put together.
#[derive(Debug, Default)]
pub(crate) struct File {
    dimensions: Vec<(String, usize)>,
    attributes: Vec<(String, Values)>,
    variables: Vec<Variable>,
}

#[derive(Debug)]
struct Variable {
    name: String,
    dimensions: Vec<usize>,
    attributes: Vec<(String, Values)>,
    values: Values,
}

impl File {
    /// Adds a dimension; one of length 0 grows with records, of which there are none.
    pub(crate) fn dimension(&mut self, name: impl Into<String>, length: usize) -> usize {
        self.dimensions.push((name.into(), length));
        self.dimensions.len() - 1
    }

    pub(crate) fn attribute(&mut self, name: &str, values: Values) {
        self.attributes.push((name.into(), values));
    }

    /// Adds a variable with as many values as its dimensions say.
    pub(crate) fn variable(
        &mut self,
        name: impl Into<String>,
        dimensions: &[usize],
        attribute: Option<(&str, &str)>,
        values: Values,
    ) {
        let attributes = attribute.map(|(n, v)| (n.to_owned(), Values::Text(v.as_bytes().to_vec())));
        self.variables.push(Variable {
            name: name.into(),
            dimensions: dimensions.to_vec(),
            attributes: attributes.into_iter().collect(),
            values,
        });
    }

    pub(crate) fn write(&self, w: &mut dyn Write) -> Result<(), IoError> {
        // The length of the head does not depend on the places in it.
        let length = self.head(0)?.len() as u64;
        w.write_all(&self.head(length)?)?;
        self.variables.iter().try_for_each(|v| v.values.write(w))
    }

    fn head(&self, mut begin: u64) -> Result<Vec<u8>, IoError> {
        // Records come behind all other data.
        let end = begin + self.variables.iter().map(|v| v.values.size()).sum::<u64>();
        let mut h: Vec<u8> = b"CDF\x02".to_vec();
        number(&mut h, 0);
        tag(&mut h, 0x0A, self.dimensions.len());
        for (name, length) in &self.dimensions {
            text(&mut h, name);
            number(&mut h, *length as u32);
        }
        attributes(&mut h, &self.attributes)?;
        tag(&mut h, 0x0B, self.variables.len());
        for v in &self.variables {
            text(&mut h, &v.name);
            number(&mut h, v.dimensions.len() as u32);
            v.dimensions.iter().for_each(|&d| number(&mut h, d as u32));
            attributes(&mut h, &v.attributes)?;
            number(&mut h, v.values.kind());
            // One record, if there were any, of a variable without values.
            let is_record = v.dimensions.first().is_some_and(|&d| self.dimensions[d].1 == 0);
            let size = if is_record { 8 } else { v.values.size() };
            number(&mut h, u32::try_from(size).unwrap_or(u32::MAX));
            h.extend(if is_record { end } else { begin }.to_be_bytes());
            begin += v.values.size();
        }
        Ok(h)
    }
}

fn number(h: &mut Vec<u8>, n: u32) {
    h.extend(n.to_be_bytes());
}

fn tag(h: &mut Vec<u8>, tag: u32, n: usize) {
    number(h, if n == 0 { 0 } else { tag });
    number(h, n as u32);
}

fn text(h: &mut Vec<u8>, name: &str) {
    number(h, name.len() as u32);
    h.extend(name.as_bytes());
    h.extend(&[0; 3][..(4 - name.len() % 4) % 4]);
}

fn attributes(h: &mut Vec<u8>, list: &[(String, Values)]) -> Result<(), IoError> {
    tag(h, 0x0C, list.len());
    for (name, values) in list {
        text(h, name);
        number(h, values.kind());
        number(h, values.len() as u32);
        values.write(h)?;
    }
    Ok(())
}
