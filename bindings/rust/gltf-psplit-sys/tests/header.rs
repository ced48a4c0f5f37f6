//! Compares the declarations of this crate with the header that is installed: `psplit/psplit.h` in the folder
//! `PSPLIT_INCLUDE_DIR`, or where pkg-config says. Each declaration becomes a line, from C and from Rust, and the lines must be
//! the same. So a member that moves, changes its type or is added fails here, and so does a function.

use std::collections::BTreeSet;
use std::process::Command;
use std::{env, fs, path::PathBuf};

fn header_folder() -> PathBuf {
    if let Some(folder) = env::var_os("PSPLIT_INCLUDE_DIR") {
        return folder.into();
    }
    let output = Command::new("pkg-config").args(["--variable=includedir", "psplit"]).output();
    let output = output.expect("PSPLIT_INCLUDE_DIR is not set, and there is no pkg-config");
    assert!(output.status.success(), "PSPLIT_INCLUDE_DIR is not set, and pkg-config does not know psplit");
    String::from_utf8(output.stdout).unwrap().trim().into()
}

/// The text without comments, with one space for each run of white space.
fn without_comments(text: &str) -> String {
    let lines: Vec<&str> = text.lines().map(|line| line.split("//").next().unwrap()).collect();
    lines.join(" ").split_whitespace().collect::<Vec<_>>().join(" ")
}

/// What stands between `begin` and the first `end` after it, for each place where `begin` is.
fn between<'a>(text: &'a str, begin: &str, end: &str) -> Vec<&'a str> {
    text.split(begin).skip(1).map(|rest| rest.split(end).next().unwrap()).collect()
}

fn is_word(c: char) -> bool {
    c.is_ascii_alphanumeric() || c == '_'
}

/// A declaration of C, such as `const char* name` or `char text[480]`, as a name and a type of Rust.
fn declaration(text: &str) -> (String, String) {
    let (text, count) = match text.trim().split_once('[') {
        Some((text, count)) => (text, Some(count.trim_end_matches(']'))),
        None => (text.trim(), None),
    };
    let name_at = text.rfind(|c| !is_word(c)).unwrap() + 1;
    let rust = type_of(&text[..name_at]);
    let rust = count.map_or(rust.clone(), |count| format!("[{}; {}]", rust, count));
    (text[name_at..].to_string(), rust)
}

fn type_of(text: &str) -> String {
    let is_const = text.trim_start().starts_with("const ");
    let base: String = text.replace("const ", "").replace('*', " ").trim().to_string();
    let mut rust = match base.as_str() {
        "uint32_t" => "u32",
        "int32_t" => "i32",
        "int64_t" => "i64",
        "uint64_t" => "u64",
        "size_t" => "usize",
        "float" => "f32",
        "double" => "f64",
        "char" => "c_char",
        "void" => "c_void",
        other => other,
    }
    .to_string();
    for star in 0..text.matches('*').count() {
        rust = format!("*{} {}", if is_const && star == 0 { "const" } else { "mut" }, rust);
    }
    rust
}

fn arguments(text: &str) -> String {
    let parts: Vec<String> = text
        .split(", ")
        .filter(|part| *part != "void")
        .map(|part| {
            let (name, rust) = declaration(part);
            format!("{}: {}", name, rust)
        })
        .collect();
    parts.join(", ")
}

fn lines_of_c(header: &str, version: &str) -> BTreeSet<String> {
    let mut lines = BTreeSet::new();
    for part in ["MAJOR", "MINOR", "PATCH"] {
        let value = between(version, &format!("#define PSPLIT_VERSION_{} ", part), "\n")[0];
        lines.insert(format!("PSPLIT_VERSION_{} = {}", part, value));
    }
    // Lines of the preprocessor declare nothing.
    let header: String = header.replace("\\\n", " ");
    let header: Vec<&str> = header.lines().filter(|line| !line.trim_start().starts_with('#')).collect();
    let text = without_comments(&header.join("\n"));
    for body in between(&text, "enum { ", "}") {
        for constant in body.split(',').filter(|part| !part.trim().is_empty()) {
            lines.insert(constant.trim().to_string());
        }
    }
    for definition in between(&text, "typedef ", "typedef ") {
        if let Some(rest) = definition.strip_prefix("struct ") {
            match rest.split_once(" {") {
                Some((name, body)) if !name.contains(';') => {
                    struct_of_c(name, body.split('}').next().unwrap(), &mut lines)
                }
                _ => drop(lines.insert(format!("{} is a handle", rest.split(' ').next().unwrap()))),
            }
        } else if let Some(rest) = definition.strip_prefix("void (*") {
            let (name, rest) = rest.split_once(")(").unwrap();
            lines.insert(format!("type {} = fn({})", name, arguments(rest.split(')').next().unwrap())));
        } else {
            let (name, rust) = declaration(definition.split(';').next().unwrap());
            lines.insert(format!("type {} = {}", name, rust));
        }
    }
    for function in between(&text, "PSPLIT_API ", ";") {
        let (front, rest) = function.split_once('(').unwrap();
        let (name, result) = declaration(front);
        let result = if result == "c_void" { String::new() } else { format!(" -> {}", result) };
        lines.insert(format!("{}({}){}", name, arguments(rest.trim_end_matches(')')), result));
    }
    lines
}

fn struct_of_c(name: &str, body: &str, lines: &mut BTreeSet<String>) {
    let mut place = 0;
    for member in body.split(';').filter(|part| !part.trim().is_empty()) {
        let mut names = member.split(',');
        let (first, rust) = declaration(names.next().unwrap());
        for member in std::iter::once(first).chain(names.map(|name| name.trim().to_string())) {
            lines.insert(format!("{} {}: {}: {}", name, place, member, rust));
            place += 1;
        }
    }
    lines.insert(format!("{} has {} members", name, place));
}

fn lines_of_rust(source: &str) -> BTreeSet<String> {
    let mut lines = BTreeSet::new();
    let text =
        without_comments(source).replace("r#", "").replace(",)", ")").replace(", )", ")").replace("( ", "(");
    for constant in between(&text, "pub const ", ";") {
        let (name, value) = constant.split_once(": ").unwrap();
        lines.insert(format!("{} = {}", name, value.split_once("= ").unwrap().1));
    }
    for definition in between(&text, "pub type ", ";") {
        let (name, rust) = definition.split_once(" = ").unwrap();
        let rust = rust.replace("Option<unsafe extern \"C\" ", "").replace(")>", ")");
        lines.insert(format!("type {} = {}", name, rust));
    }
    for handle in between(&text, "opaque!(", ")") {
        lines.insert(format!("{} is a handle", handle));
    }
    for body in between(&text, "c_struct! { pub struct ", "} }") {
        let (name, members) = body.split_once(" {").unwrap();
        let members: Vec<&str> = between(members, "pub ", ",");
        for (place, member) in members.iter().enumerate() {
            lines.insert(format!("{} {}: {}", name, place, member));
        }
        lines.insert(format!("{} has {} members", name, members.len()));
    }
    for function in between(&text, "pub fn psplit_", ";") {
        lines.insert(format!("psplit_{}", function));
    }
    lines
}

#[test]
fn declarations_are_those_of_the_header() {
    let folder = header_folder().join("psplit");
    let read = |name: &str| {
        let file = folder.join(name);
        fs::read_to_string(&file).unwrap_or_else(|error| panic!("{}: {}", file.display(), error))
    };
    let c = lines_of_c(&read("psplit.h"), &read("version.h"));
    let rust = lines_of_rust(include_str!("../src/lib.rs"));
    let only_c: Vec<_> = c.difference(&rust).collect();
    let only_rust: Vec<_> = rust.difference(&c).collect();
    assert!(
        only_c.is_empty() && only_rust.is_empty(),
        "only in C: {:#?}\nonly in Rust: {:#?}",
        only_c,
        only_rust
    );
    // The texts were understood: there are some of each kind.
    for line in [
        "psplit_version() -> u32",
        "psplit_error 5: text: [c_char; 480]",
        "psplit_mesh is a handle",
        "PSPLIT_COPY = 1",
    ] {
        assert!(c.contains(line), "{}", line);
    }
}

#[test]
fn changes_of_the_header_are_seen() {
    let header = "typedef struct a {\n  uint32_t struct_size;  // size\n  float x, y;\n} a;\nPSPLIT_API void f(const a* p, size_t n);";
    let version =
        "#define PSPLIT_VERSION_MAJOR 0\n#define PSPLIT_VERSION_MINOR 1\n#define PSPLIT_VERSION_PATCH 2\n";
    let lines = lines_of_c(header, version);
    for line in [
        "a 0: struct_size: u32",
        "a 2: y: f32",
        "a has 3 members",
        "f(p: *const a, n: usize)",
        "PSPLIT_VERSION_PATCH = 2",
    ] {
        assert!(lines.contains(line), "{} is not in {:#?}", line, lines);
    }
    assert_ne!(lines, lines_of_c(&header.replace("x, y", "x"), version));
    assert_ne!(lines, lines_of_c(&header.replace("size_t n", "uint32_t n"), version));
}

#[test]
fn the_library_is_of_the_same_version() {
    // SAFETY: a function without arguments.
    let version = unsafe { gltf_psplit_sys::psplit_version() };
    assert_eq!(
        version >> 8,
        gltf_psplit_sys::PSPLIT_VERSION_MAJOR * 0x100 + gltf_psplit_sys::PSPLIT_VERSION_MINOR
    );
}
