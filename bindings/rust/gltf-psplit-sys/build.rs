//! Says where libpsplit is: in the folder `PSPLIT_LIB_DIR`, or where pkg-config finds `psplit`.

use std::env;
use std::process::Command;

fn main() {
    println!("cargo:rerun-if-env-changed=PSPLIT_LIB_DIR");
    println!("cargo:rerun-if-env-changed=PKG_CONFIG");
    println!("cargo:rerun-if-env-changed=PKG_CONFIG_PATH");
    let folder = match env::var("PSPLIT_LIB_DIR") {
        Ok(folder) if !folder.is_empty() => folder,
        _ => match folder_of_pkg_config() {
            Ok(folder) => folder,
            // Documentation needs no library.
            Err(_) if env::var_os("DOCS_RS").is_some() => return,
            Err(why) => panic!(
                "libpsplit was not found: {}. PSPLIT_LIB_DIR names the folder that it is in; \
                 docs/rust.md of psplit says how to build it",
                why
            ),
        },
    };
    println!("cargo:rustc-link-search=native={}", folder);
    println!("cargo:rustc-link-lib=dylib=psplit");
    // Build scripts of crates that depend on this one get it as DEP_PSPLIT_LIB_DIR.
    println!("cargo:lib_dir={}", folder);
}

fn folder_of_pkg_config() -> Result<String, String> {
    let program = env::var("PKG_CONFIG").unwrap_or_else(|_| "pkg-config".to_string());
    let output = Command::new(&program)
        .args(["--variable=libdir", "psplit"])
        .output()
        .map_err(|error| format!("{}: {}", program, error))?;
    let text = String::from_utf8_lossy(&output.stdout).trim().to_string();
    if output.status.success() && !text.is_empty() {
        return Ok(text);
    }
    Err(format!("{} knows no package psplit: {}", program, String::from_utf8_lossy(&output.stderr).trim()))
}
