//! Wavefront OBJ.

use super::TriangleSoup;
use rockfall_math::Vec3;
use tobj::{LoadError, LoadOptions};

/// The polygons of all objects and groups, cut into fans.
pub(super) fn parse(bytes: &[u8]) -> Result<TriangleSoup, String> {
    let geometry = geometry(bytes)?;
    let options = LoadOptions { triangulate: true, ..LoadOptions::default() };
    let no_materials = |_: &std::path::Path| Err(LoadError::OpenFileFailed);
    let (models, _) =
        tobj::load_obj_buf(&mut geometry.as_bytes(), &options, no_materials).map_err(|e| e.to_string())?;
    let mut soup = TriangleSoup::default();
    for model in models {
        let first = soup.vertices.len() as u32;
        soup.vertices.extend(model.mesh.positions.as_chunks().0.iter().map(|p| Vec3::from_array(*p)));
        soup.triangles.extend(model.mesh.indices.as_chunks().0.iter().map(|t| t.map(|c| first + c)));
    }
    Ok(soup)
}

/// The lines that place vertices and faces, checked one by one, because the library names no line. Texture
/// coordinates, normals and colours are cut off: those can be broken without harm to the geometry.
fn geometry(bytes: &[u8]) -> Result<String, String> {
    // Names may be in any encoding. A backslash continues a line.
    let text = String::from_utf8_lossy(bytes);
    let mut lines = String::with_capacity(text.len());
    let (mut count, mut highest) = (0_i64, (0_i64, 0));
    let mut whole = String::new();
    for (i, line) in text.lines().enumerate() {
        let line = line.split('#').next().unwrap_or_default().trim_end();
        if let Some(begun) = line.strip_suffix('\\') {
            whole.push_str(begun);
            whole.push(' ');
            continue;
        }
        whole.push_str(line);
        let mut words = whole.split_whitespace();
        let wrong = |what: String| Err(format!("line {}: {what}", i + 1));
        let kept: Vec<&str> = match words.next() {
            Some("v") => {
                let numbers: Vec<&str> = words.collect();
                if numbers.len() < 3 || numbers[..3].iter().any(|n| n.parse::<f32>().is_err()) {
                    return wrong("expected `v` and three numbers".into());
                }
                count += 1;
                // Four numbers are x, y, z and a weight; more are a place and a colour.
                let wanted = if numbers.len() == 4 { 4 } else { 3 };
                ["v"].into_iter().chain(numbers.into_iter().take(wanted)).collect()
            }
            Some("f") => {
                let corners: Vec<&str> = words.filter_map(|w| w.split('/').next()).collect();
                if corners.len() < 3 {
                    return wrong("a face needs at least 3 corners".into());
                }
                for corner in &corners {
                    match corner.parse::<i64>() {
                        Ok(c) if c > 0 => highest = highest.max((c, i + 1)),
                        Ok(c) if c < 0 && c >= -count => {}
                        Ok(c) => {
                            return wrong(format!("a face names vertex {c}, but there are {count} so far"));
                        }
                        Err(_) => return wrong(format!("expected the number of a vertex, found `{corner}`")),
                    }
                }
                ["f"].into_iter().chain(corners).collect()
            }
            _ => Vec::new(),
        };
        if !kept.is_empty() {
            lines.push_str(&kept.join(" "));
            lines.push('\n');
        }
        whole.clear();
    }
    match highest {
        (c, line) if c > count => {
            Err(format!("line {line}: a face names vertex {c}, but there are only {count}"))
        }
        _ => Ok(lines),
    }
}
