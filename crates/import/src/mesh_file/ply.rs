//! Polygon files (PLY), text and binary.

use super::TriangleSoup;
use ply_rs_bw::parser::{ParseError, Parser, Reader};
use ply_rs_bw::ply::{
    ElementDef, Encoding, Header, Property, PropertyAccess, PropertyAccessResult, PropertyType, ScalarType,
};
use rockfall_math::Vec3;

/// The polygons of the element `face`, cut into fans, over the places of the element `vertex`.
pub(super) fn parse(bytes: &[u8]) -> Result<TriangleSoup, String> {
    let mut reader = Reader::new(bytes);
    let header = Parser::<Other>::new().read_header(&mut reader).map_err(reason)?;
    let mut soup = TriangleSoup::default();
    for element in header.elements.values() {
        check_count(element, header.encoding, reader.get_ref().len())?;
        match element.name.as_str() {
            "vertex" => {
                check_vertex(element)?;
                let vertices: Vec<Vertex> = rows(&mut reader, element, &header)?;
                soup.vertices = vertices.into_iter().map(|v| v.0).collect();
            }
            "face" => {
                let faces: Vec<Face> = rows(&mut reader, element, &header)?;
                faces.iter().for_each(|f| soup.push_polygon(&f.0));
            }
            _ => drop(rows::<Other>(&mut reader, element, &header)?),
        }
    }
    Ok(soup)
}

fn rows<E: PropertyAccess>(
    reader: &mut Reader<&[u8]>,
    element: &ElementDef,
    header: &Header,
) -> Result<Vec<E>, String> {
    Parser::new().read_payload_for_element(reader, element, header).map_err(reason)
}

/// What the library says, but for its lists of all tokens that it would have taken, whose order changes.
fn reason(error: ParseError) -> String {
    let text = error.to_string();
    let end = ["Error: ParseError", "Error: error at"].iter().filter_map(|list| text.find(list)).min();
    text[..end.unwrap_or(text.len())].to_owned()
}

/// Holds what the header claims against what is left of the file. A row of text takes at least its line
/// break.
fn check_count(element: &ElementDef, encoding: Encoding, left: usize) -> Result<(), String> {
    let least = match encoding {
        Encoding::Ascii => 1,
        _ => element.properties.values().map(|p| size(&p.data_type)).sum(),
    };
    let (name, count) = (&element.name, element.count);
    if count > 0 && least == 0 {
        return Err(format!("its {count} rows of `{name}` have no properties"));
    }
    match count.checked_mul(least) {
        // The last line may lack its break.
        Some(needed) if needed <= left + 1 => Ok(()),
        _ => Err(format!("the header announces {count} rows of `{name}`, but only {left} bytes follow")),
    }
}

/// The fewest bytes that a property takes in a binary file.
fn size(property: &PropertyType) -> usize {
    let (PropertyType::Scalar(scalar) | PropertyType::List(scalar, _)) = property;
    match scalar {
        ScalarType::Char | ScalarType::UChar => 1,
        ScalarType::Short | ScalarType::UShort => 2,
        ScalarType::Int | ScalarType::UInt | ScalarType::Float => 4,
        ScalarType::Double => 8,
    }
}

fn check_vertex(element: &ElementDef) -> Result<(), String> {
    match ["x", "y", "z"].iter().find(|axis| !element.properties.contains_key(**axis)) {
        Some(axis) => Err(format!("its vertices have no `{axis}`")),
        None => Ok(()),
    }
}

struct Vertex(Vec3);

impl PropertyAccess for Vertex {
    fn new() -> Self {
        Vertex(Vec3::ZERO)
    }

    fn set_property(&mut self, name: &str, property: Property) -> PropertyAccessResult {
        let coordinate = match name {
            "x" => &mut self.0.x,
            "y" => &mut self.0.y,
            "z" => &mut self.0.z,
            _ => return PropertyAccessResult::Ignored,
        };
        let Some(number) = property.to_f32_lossy() else { return PropertyAccessResult::UnsupportedType };
        *coordinate = number;
        PropertyAccessResult::Set
    }
}

struct Face(Vec<u32>);

impl PropertyAccess for Face {
    fn new() -> Self {
        Face(Vec::new())
    }

    fn set_property(&mut self, name: &str, property: Property) -> PropertyAccessResult {
        if !matches!(name, "vertex_indices" | "vertex_index") {
            return PropertyAccessResult::Ignored;
        }
        let Some(corners) = property.to_u32_list() else { return PropertyAccessResult::UnsupportedType };
        self.0 = corners;
        PropertyAccessResult::Set
    }
}

/// Rows that say nothing about the surface.
struct Other;

impl PropertyAccess for Other {
    fn new() -> Self {
        Other
    }
}
