//! The sections of a DXF file: header, tables, blocks, entities.

use std::collections::HashMap;

use encoding_rs::Encoding;

use super::damage::Damage;
use super::entity::{Entity, Fields, Hidden, Shape, Vec3, Vertex, polyline, shape_of};
use super::tags::{Tag, Tags};

/// The parts of a DXF file that matter for contours.
#[derive(Debug, Default)]
pub struct DxfFile {
    /// `$INSUNITS`, if the file states it.
    pub units: Option<i64>,
    /// Layers by name, in upper case.
    pub layers: HashMap<String, Layer>,
    /// Whether a line type has gaps, by its name in upper case.
    pub gaps: HashMap<String, bool>,
    /// Blocks by name, in upper case.
    pub blocks: HashMap<String, Block>,
    /// The entities of model and paper space.
    pub entities: Vec<Entity>,
    /// Names of layers, line types and blocks.
    pub names: Names,
    /// Whether the file has its end mark (EOF).
    pub ends_well: bool,
}

impl DxfFile {
    /// Whether the layer is never plotted. Defpoints, where CAD systems keep the points of dimensions, is not.
    #[must_use]
    pub fn is_unplotted(&self, layer: &str) -> bool {
        let name = folded(layer);
        name == "DEFPOINTS" || self.layers.get(&name).is_some_and(|layer| layer.unplotted)
    }
}

/// A layer.
#[derive(Clone, Debug, Default)]
pub struct Layer {
    /// Whether it is frozen.
    pub frozen: bool,
    /// Whether it is switched off.
    pub off: bool,
    /// Whether it is never plotted.
    pub unplotted: bool,
    /// Its line type.
    pub line_type: String,
}

/// A block.
#[derive(Debug, Default)]
pub struct Block {
    /// The base point: an insert puts it at the insertion point.
    pub base: Vec3,
    /// Whether the block is a reference to another file.
    pub external: bool,
    /// Its entities.
    pub entities: Vec<Entity>,
}

/// The names of a file, each with a number.
#[derive(Debug, Default)]
pub struct Names {
    names: Vec<std::sync::Arc<str>>,
    numbers: HashMap<Vec<u8>, u32>,
    encoding: Option<&'static Encoding>,
}

impl Names {
    /// The name with the number.
    #[must_use]
    pub fn get(&self, number: u32) -> &std::sync::Arc<str> {
        &self.names[number as usize]
    }

    /// Whether the file has the name anywhere.
    #[must_use]
    pub fn has(&self, name: &str) -> bool {
        let wanted = folded(name);
        self.names.iter().any(|one| folded(one) == wanted)
    }

    fn number(&mut self, bytes: &[u8]) -> u32 {
        if let Some(&number) = self.numbers.get(bytes) {
            return number;
        }
        let number = u32::try_from(self.names.len()).unwrap_or(u32::MAX);
        self.names.push(self.decode(bytes).into());
        self.numbers.insert(bytes.to_vec(), number);
        number
    }

    /// Decodes text as UTF-8 if it is valid UTF-8, else by the code page that the header states.
    fn decode(&self, bytes: &[u8]) -> String {
        let text = match std::str::from_utf8(bytes) {
            Ok(text) => text.to_string(),
            Err(_) => self.encoding.unwrap_or(encoding_rs::WINDOWS_1252).decode(bytes).0.into_owned(),
        };
        escapes(&text).replace(char::is_control, "\u{fffd}")
    }
}

/// The name in capitals: CAD systems compare names without regard to case. A letter without a capital,
/// or with a capital of two letters, stays unchanged.
pub fn folded(name: &str) -> String {
    let capital = |letter: char| {
        let mut capitals = letter.to_uppercase();
        capitals.next().filter(|_| capitals.next().is_none()).unwrap_or(letter)
    };
    name.chars().map(capital).collect()
}

/// Replaces escapes such as `\U+00E4` by their characters.
fn escapes(text: &str) -> String {
    let mut out = String::new();
    let mut rest = text;
    while let Some(at) = rest.find("\\U+") {
        let digits = rest.get(at + 3..at + 7);
        let character =
            digits.and_then(|digits| u32::from_str_radix(digits, 16).ok()).and_then(char::from_u32);
        let Some(character) = character else { break };
        out.push_str(&rest[..at]);
        out.push(character);
        rest = &rest[at + 7..];
    }
    out + rest
}

/// The encoding of a `$DWGCODEPAGE`, such as `ANSI_1252`.
fn encoding_of(page: &[u8]) -> Option<&'static Encoding> {
    let page = std::str::from_utf8(page).ok()?.to_ascii_lowercase();
    let number = page.trim_start_matches(|c: char| !c.is_ascii_digit());
    let label = match number {
        "932" => "shift_jis".to_string(),
        "936" => "gbk".to_string(),
        "949" => "euc-kr".to_string(),
        "950" => "big5".to_string(),
        "866" => "ibm866".to_string(),
        number => format!("windows-{number}"),
    };
    Encoding::for_label(label.as_bytes())
}

/// Reads the file.
///
/// # Errors
/// [`Damage`] with the place.
pub fn read(bytes: &[u8]) -> Result<DxfFile, Damage> {
    Damage::other_file(bytes).map_or(Ok(()), Err)?;
    let mut reader = Reader { tags: Tags::new(bytes)?, group: Vec::new(), file: DxfFile::default() };
    let mut sections = 0;
    while let Some(tag) = reader.tags.next()? {
        match (tag.code, tag.text()) {
            (0, b"SECTION") => {
                sections += 1;
                reader.section()?;
            }
            (0, b"EOF") => {
                reader.file.ends_well = true;
                break;
            }
            _ => {}
        }
    }
    if sections == 0 { Err(Damage::NoDxf) } else { Ok(reader.file) }
}

struct Reader<'a> {
    tags: Tags<'a>,
    /// Groups of the current entity.
    group: Vec<Tag<'a>>,
    file: DxfFile,
}

impl<'a> Reader<'a> {
    fn section(&mut self) -> Result<(), Damage> {
        let name = self.tags.next()?.filter(|tag| tag.code == 2).map_or(&b""[..], |tag| tag.text());
        match name {
            b"HEADER" => self.header(),
            b"TABLES" => self.tables(),
            b"BLOCKS" => self.blocks(),
            b"ENTITIES" => {
                // Some writers split the entities over several sections.
                let mut entities = std::mem::take(&mut self.file.entities);
                let ended = self.entities(&mut entities, b"ENDSEC");
                self.file.entities = entities;
                ended.map(|_| ())
            }
            _ => self.skip(),
        }
    }

    /// The next group inside a section; the section must end before the file does.
    fn inside(&mut self, inside: &'static str) -> Result<Tag<'a>, Damage> {
        let at = self.tags.place();
        self.tags.next()?.ok_or(Damage::EndsEarly { at, inside })
    }

    fn skip(&mut self) -> Result<(), Damage> {
        while let Some(tag) = self.tags.next()? {
            if tag.code == 0 && matches!(tag.text(), b"ENDSEC" | b"EOF" | b"SECTION") {
                if tag.text() != b"ENDSEC" {
                    self.tags.hold(tag);
                }
                break;
            }
        }
        Ok(())
    }

    /// Ends a section at this group. If the group is not the section's own end, it is held and read again.
    fn leave(&mut self, tag: Tag<'a>) {
        if tag.text() != b"ENDSEC" {
            self.tags.hold(tag);
        }
    }

    fn header(&mut self) -> Result<(), Damage> {
        let mut variable: &[u8] = b"";
        loop {
            let tag = self.inside("the header")?;
            match (tag.code, variable) {
                (0, _) => {
                    self.leave(tag);
                    return Ok(());
                }
                (9, _) => variable = tag.text(),
                (70, b"$INSUNITS") => self.file.units = tag.integer().ok(),
                (3, b"$DWGCODEPAGE") => self.file.names.encoding = encoding_of(tag.text()),
                _ => {}
            }
        }
    }

    /// Reads the groups up to the next group of code 0 into `self.group`, and returns that group.
    fn gather(&mut self, inside: &'static str) -> Result<Tag<'a>, Damage> {
        self.group.clear();
        loop {
            let tag = self.inside(inside)?;
            if tag.code == 0 {
                return Ok(tag);
            }
            self.group.push(tag);
        }
    }

    fn tables(&mut self) -> Result<(), Damage> {
        let mut head = self.gather("the tables")?;
        while !matches!(head.text(), b"ENDSEC" | b"EOF" | b"SECTION") {
            let next = self.gather("the tables")?;
            let fields = Fields::new(&self.group);
            let name = folded(&self.file.names.decode(fields.text(2)));
            match head.text() {
                b"LAYER" => {
                    let layer = Layer {
                        frozen: fields.integer(70, 0).unwrap_or(0) & 1 != 0,
                        off: fields.integer(62, 7).unwrap_or(7) < 0,
                        unplotted: fields.integer(290, 1).unwrap_or(1) == 0,
                        line_type: folded(&self.file.names.decode(fields.text(6))),
                    };
                    self.file.layers.insert(name, layer);
                }
                b"LTYPE" => {
                    let gaps = fields.integer(73, 0).unwrap_or(0) > 0;
                    self.file.gaps.insert(name, gaps);
                }
                _ => {}
            }
            head = next;
        }
        self.leave(head);
        Ok(())
    }

    fn blocks(&mut self) -> Result<(), Damage> {
        let mut head = self.gather("the blocks")?;
        loop {
            match head.text() {
                b"ENDSEC" => return Ok(()),
                b"EOF" | b"SECTION" => {
                    self.leave(head);
                    return Ok(());
                }
                b"BLOCK" => {
                    let next = self.gather("a block")?;
                    let fields = Fields::new(&self.group);
                    let name = folded(&self.file.names.decode(fields.text(2)));
                    let mut block = Block {
                        base: fields.point(10, [0.0; 3])?,
                        external: fields.integer(70, 0)? & 4 != 0,
                        entities: Vec::new(),
                    };
                    self.tags.hold(next);
                    let end = self.entities(&mut block.entities, b"ENDBLK")?;
                    self.file.blocks.insert(name, block);
                    match end {
                        End::Block => head = self.gather("the blocks")?,
                        End::Section => return Ok(()),
                    }
                }
                _ => head = self.gather("the blocks")?,
            }
        }
    }

    /// Reads entities up to `end`, or the end of the section.
    fn entities(&mut self, entities: &mut Vec<Entity>, end: &[u8]) -> Result<End, Damage> {
        let mut head = self.inside("the entities")?;
        while head.code != 0 {
            head = self.inside("the entities")?;
        }
        loop {
            let kind = head.text();
            if kind == end {
                return Ok(if end == b"ENDBLK" { End::Block } else { End::Section });
            }
            match kind {
                b"ENDSEC" => return Ok(End::Section),
                b"EOF" | b"SECTION" => {
                    self.tags.hold(head);
                    return Ok(End::Section);
                }
                b"POLYLINE" => head = self.old_polyline(head, entities)?,
                _ => {
                    let next = self.gather("an entity")?;
                    let names = &mut self.file.names;
                    let fields = Fields::new(&self.group);
                    let shape = shape_of(kind, fields, &mut |name| names.number(name))?;
                    entities.push(entity(head, fields, shape, names)?);
                    head = next;
                }
            }
        }
    }

    /// Reads a POLYLINE with its VERTEX entities up to SEQEND; returns the head of the next entity.
    fn old_polyline(&mut self, head: Tag<'a>, entities: &mut Vec<Entity>) -> Result<Tag<'a>, Damage> {
        let mut next = self.gather("a polyline")?;
        let own = self.group.clone();
        let mut vertices: Vec<Vertex> = Vec::new();
        while next.text() == b"VERTEX" {
            next = self.gather("a polyline")?;
            let fields = Fields::new(&self.group);
            vertices.push(Vertex {
                at: fields.point(10, [0.0; 3])?,
                bulge: fields.real(42, 0.0)?,
                width: fields.largest(40, fields.largest(41, 0.0)),
                flags: fields.integer(70, 0)?,
            });
        }
        if next.text() == b"SEQEND" {
            next = self.gather("a polyline")?;
        }
        let fields = Fields::new(&own);
        let shape = match polyline(fields, &vertices)? {
            Some(line) => Shape::Polyline(Box::new(line)),
            None => Shape::Other("solid, surface or mesh"),
        };
        entities.push(entity(head, fields, shape, &mut self.file.names)?);
        Ok(next)
    }
}

/// The end of a list of entities: of a block, or of a section.
#[derive(Clone, Copy, PartialEq, Eq)]
enum End {
    Block,
    Section,
}

fn entity(head: Tag<'_>, fields: Fields<'_, '_>, shape: Shape, names: &mut Names) -> Result<Entity, Damage> {
    let hidden = if fields.integer(67, 0)? != 0 {
        Some(Hidden::Paper)
    } else if fields.integer(60, 0)? != 0 {
        Some(Hidden::Invisible)
    } else {
        None
    };
    let layer = fields.find(8).map_or(&b"0"[..], |tag| tag.text());
    let handle = std::str::from_utf8(fields.text(5)).ok();
    let handle = handle.and_then(|digits| u64::from_str_radix(digits, 16).ok()).unwrap_or(0);
    Ok(Entity {
        at: head.at,
        handle,
        layer: names.number(layer),
        line_type: fields.find(6).map(|tag| names.number(tag.text())),
        hidden,
        normal: fields.point(210, [0.0, 0.0, 1.0])?,
        shape,
    })
}
