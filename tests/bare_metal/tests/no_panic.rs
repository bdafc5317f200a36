//! Nothing that a real-time loop calls can panic or allocate, in `f32` and in `f64`, optimised for
//! speed and for size.
//!
//! The firmware beside this package is built as an archive, as a microcontroller's would be:
//! without std, with a panic handler of its own, link-time optimisation, `panic = "abort"`. In such
//! code a panic is a call of the handler. From each exported function all that is called or pointed
//! at is followed, symbol by symbol and section by section, through every object of the archive,
//! and none of it may be the handler, a part of `core::panicking` or an allocator. A pointer counts
//! as a call, so that what is found not to be there is not there.
//!
//! That is a statement on the code that the optimiser leaves: it removes checks that cannot fail.
//! Without optimisation they are there, and cannot fail either.

use std::collections::{HashMap, HashSet, VecDeque};
use std::path::{Path, PathBuf};
use std::process::Command;

use object::read::archive::ArchiveFile;
use object::{Object, ObjectSection, ObjectSymbol, RelocationTarget, SymbolSection};

/// One section of one object: in Rust's archives, one function or one table.
type Place = (usize, usize);

/// Who calls whom.
#[derive(Default)]
struct Calls {
    /// What each section refers to.
    edges: HashMap<Place, Vec<Target>>,
    /// Where each name is defined, one section or more.
    definitions: HashMap<String, Vec<Place>>,
    /// Names of what each section defines.
    names: HashMap<Place, Vec<String>>,
}

#[derive(Clone)]
enum Target {
    Section(Place),
    Name(String),
}

impl Calls {
    fn of(archive: &Path) -> Self {
        let data = std::fs::read(archive).unwrap();
        let mut calls = Self::default();
        for (number, member) in ArchiveFile::parse(&*data).unwrap().members().enumerate() {
            // What is no object (an index, metadata) calls nothing.
            let Ok(file) = object::File::parse(member.unwrap().data(&*data).unwrap()) else {
                continue;
            };
            calls.add(number, &file);
        }
        calls
    }

    fn add(&mut self, number: usize, file: &object::File<'_>) {
        for symbol in file.symbols() {
            let (Ok(name), SymbolSection::Section(section)) = (symbol.name(), symbol.section())
            else {
                continue;
            };
            if !name.is_empty() {
                let place = (number, section.0);
                self.names.entry(place).or_default().push(name.to_owned());
                if symbol.is_global() {
                    self.definitions.entry(name.to_owned()).or_default().push(place);
                }
            }
        }
        for section in file.sections() {
            let from = self.edges.entry((number, section.index().0)).or_default();
            for (_, relocation) in section.relocations() {
                match relocation.target() {
                    RelocationTarget::Section(index) => {
                        from.push(Target::Section((number, index.0)))
                    }
                    RelocationTarget::Symbol(index) => {
                        let symbol = file.symbol_by_index(index).unwrap();
                        from.push(match symbol.section() {
                            SymbolSection::Section(index) => Target::Section((number, index.0)),
                            _ => Target::Name(symbol.name().unwrap().to_owned()),
                        });
                    }
                    _ => {}
                }
            }
        }
    }

    /// The names that start so, of functions exported.
    fn exported(&self, prefix: &str) -> Vec<String> {
        let mut names: Vec<_> =
            self.definitions.keys().filter(|name| name.starts_with(prefix)).cloned().collect();
        names.sort();
        names
    }

    /// The way from a function to the first thing that is forbidden, and the names defined nowhere
    /// on the way.
    fn forbidden(&self, entry: &str) -> (Option<String>, HashSet<String>) {
        let (mut queue, mut came) = (VecDeque::new(), HashMap::new());
        let mut foreign = HashSet::new();
        for &place in &self.definitions[entry] {
            queue.push_back(place);
            came.insert(place, None);
        }
        while let Some(place) = queue.pop_front() {
            let names = self.names.get(&place).map_or(&[][..], Vec::as_slice);
            if let Some(bad) = names.iter().find(|name| is_forbidden(name)) {
                return (Some(format!("{bad} {}", self.way(&came, place))), foreign);
            }
            for target in &self.edges[&place] {
                let next = match target {
                    Target::Section(place) => vec![*place],
                    Target::Name(name) if is_forbidden(name) => {
                        return (Some(format!("{name} from {}", self.way(&came, place))), foreign);
                    }
                    Target::Name(name) => {
                        self.definitions.get(name).cloned().unwrap_or_else(|| {
                            foreign.insert(name.clone());
                            Vec::new()
                        })
                    }
                };
                for next in next {
                    came.entry(next).or_insert_with(|| {
                        queue.push_back(next);
                        Some(place)
                    });
                }
            }
        }
        (None, foreign)
    }

    fn way(&self, came: &HashMap<Place, Option<Place>>, mut place: Place) -> String {
        let mut way = String::new();
        loop {
            let names = self.names.get(&place).map(|names| names.join("/"));
            way += &format!("<- {} ", names.unwrap_or_else(|| format!("{place:?}")));
            match came[&place] {
                Some(before) => place = before,
                None => return way,
            }
        }
    }
}

/// Panics, and the ways to an allocator.
fn is_forbidden(name: &str) -> bool {
    [
        "bristle_firmware_panicked",
        "rust_begin_unwind",
        "panicking",
        "__rust_alloc",
        "__rust_realloc",
    ]
    .iter()
    .any(|bad| name.contains(bad))
        || ["malloc", "abort"].contains(&name)
}

/// Builds the firmware in a profile and returns its archive.
fn firmware(profile: &str) -> PathBuf {
    let here = Path::new(env!("CARGO_MANIFEST_DIR"));
    let target = Path::new(env!("CARGO_TARGET_TMPDIR")).join("firmware");
    let built = Command::new(env!("CARGO"))
        .args(["build", "--quiet", "--package", "bristle-firmware", "--profile", profile])
        .arg("--target-dir")
        .arg(&target)
        .current_dir(here)
        .status()
        .unwrap();
    assert!(built.success());
    target.join(profile).join("libbristle_firmware.a")
}

/// What the archive may ask of others: nothing but memory copies and comparisons, which every
/// platform has.
const FOREIGN: [&str; 5] = ["memcpy", "memmove", "memset", "memcmp", "bcmp"];

fn check(profile: &str) {
    let calls = Calls::of(&firmware(profile));
    // The probes show that it would be seen.
    let probes = calls.exported("probe_");
    assert_eq!(probes.len(), 4, "{probes:?}");
    for probe in probes {
        assert!(calls.forbidden(&probe).0.is_some(), "{probe} is not seen to be forbidden");
    }
    let entries = calls.exported("entry_");
    assert!(entries.len() >= 74, "{entries:?}");
    let mut found = Vec::new();
    for entry in entries {
        let (way, foreign) = calls.forbidden(&entry);
        found.extend(way);
        let unknown: Vec<_> =
            foreign.iter().filter(|name| !FOREIGN.contains(&name.as_str())).collect();
        assert!(unknown.is_empty(), "{entry} calls {unknown:?}");
    }
    assert!(found.is_empty(), "{profile}, {}:\n{}", found.len(), found.join("\n"));
}

#[test]
fn no_step_and_no_constructor_can_panic_or_allocate_built_for_speed() {
    check("release");
}

#[test]
fn no_step_and_no_constructor_can_panic_or_allocate_built_for_size() {
    check("small");
}
