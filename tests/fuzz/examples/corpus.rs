//! Writes the seeds of every target to `fuzz/corpus/TARGET/`, where `cargo fuzz run TARGET` begins.

fn main() -> std::io::Result<()> {
    let root = concat!(env!("CARGO_MANIFEST_DIR"), "/../../fuzz/corpus");
    for target in isolux_fuzz::targets() {
        let folder = format!("{root}/{}", target.name);
        std::fs::create_dir_all(&folder)?;
        for (k, seed) in (target.seeds)().into_iter().enumerate() {
            std::fs::write(format!("{folder}/seed-{k}"), seed)?;
        }
    }
    Ok(())
}
