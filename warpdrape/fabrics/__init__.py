"""The material library: one TOML file a fabric."""
