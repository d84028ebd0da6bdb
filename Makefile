# `make demo` and `make test` are all that a fresh machine with cargo needs; each does its own set-up.
.DEFAULT_GOAL := help
SCENE ?= cornell-knot
ANIMATION ?=
BAKE = target/release/bake
PLAYER = target/release/player
SECONDS ?= 600
PREFIX ?= /usr/local
.PHONY: help setup build install assets bake play chart gallery figures demo test test-long fuzz sweep bench lint

help:   ## list the targets
	@grep -E '^[a-z-]+: .*##' $(MAKEFILE_LIST) | sed -E 's/:.*## /\t/' | expand -t 10
setup:  ## install missing system libraries, or say which are missing
	@sh .ci/setup
build: setup  ## build both programs
	cargo build --release --workspace
install: build  ## install programs, library of scenes, manual pages and completions for bash, zsh and fish below PREFIX=/usr/local
	install -d $(foreach folder,bin share/man/man1 share/bash-completion/completions share/zsh/site-functions share/fish/vendor_completions.d share/relume/scenes,$(DESTDIR)$(PREFIX)/$(folder))
	install $(BAKE) $(PLAYER) $(DESTDIR)$(PREFIX)/bin
	cp -R scenes/library $(DESTDIR)$(PREFIX)/share/relume/scenes
	$(BAKE) -q man -o $(DESTDIR)$(PREFIX)/share/man/man1
	$(PLAYER) --man >$(DESTDIR)$(PREFIX)/share/man/man1/player.1
	$(BAKE) completions bash >$(DESTDIR)$(PREFIX)/share/bash-completion/completions/bake
	$(PLAYER) --completions bash >$(DESTDIR)$(PREFIX)/share/bash-completion/completions/player
	$(BAKE) completions zsh >$(DESTDIR)$(PREFIX)/share/zsh/site-functions/_bake
	$(PLAYER) --completions zsh >$(DESTDIR)$(PREFIX)/share/zsh/site-functions/_player
	$(BAKE) completions fish >$(DESTDIR)$(PREFIX)/share/fish/vendor_completions.d/bake.fish
	$(PLAYER) --completions fish >$(DESTDIR)$(PREFIX)/share/fish/vendor_completions.d/player.fish
assets:  ## fetch the pinned third-party assets
	sh scenes/fetch-assets.sh
bake: build  ## bake SCENE=<name> into baked/<name>
	@if grep -qs '"assets/' scenes/library/$(SCENE)/scene.toml; then sh scenes/fetch-assets.sh; fi
	$(BAKE) run $(SCENE)
play: build  ## play SCENE=<name> [ANIMATION=<name>] in a window, or without a display to frames and a contact sheet in baked/
	@if [ -n "$$DISPLAY$$WAYLAND_DISPLAY" ]; then \
	    $(PLAYER) baked/$(SCENE) $(if $(ANIMATION),--animation $(ANIMATION)); \
	else \
	    animation=$(or $(ANIMATION),$$(ls baked/$(SCENE) | sed -n 's/^animation-\(.*\)\.relume$$/\1/p' | head -n 1)); \
	    $(PLAYER) baked/$(SCENE) --headless --animation $$animation --fps 12 --frames "baked/frames/$(SCENE)-$$animation/%04d.png" --contact-sheet baked/frames/$(SCENE)-$$animation.png && \
	    echo "look at baked/frames/$(SCENE)-$$animation.png; single frames are in baked/frames/$(SCENE)-$$animation"; \
	fi
chart: build  ## chart speed against accuracy of SCENE=<name> into charts/<name>; leave the machine alone meanwhile
	@if grep -qs '"assets/' scenes/library/$(SCENE)/scene.toml; then sh scenes/fetch-assets.sh; fi
	$(BAKE) chart $(SCENE)
gallery: build  ## chart all scenes of the library, or SCENES="a b", into docs/gallery and say what changed; takes hours
	$(BAKE) gallery $(SCENES)
figures:  ## print the tables of docs/notes/TRANSFER-TENSOR.md: lobes, and reflected light by texels, clusters, ranks and bases; takes half an hour
	cargo build --release --examples
	@for model in cook-torrance ggx blinn-phong; do target/release/examples/brdf_tensor figures $$model || exit 1; done
	target/release/examples/bounced_tensor bake/examples/open-box/scene.toml made
	target/release/examples/bounced_tensor bake/examples/open-box/coarse.toml small
	target/release/examples/bounced_twice bake/examples/open-box/coarse.toml
demo: build  ## bake a small scene and play its animations in a window, or without a display to pictures in demo/
	$(BAKE) run cornell-knot --quality final -o demo/cornell-knot
	@if [ -n "$$DISPLAY$$WAYLAND_DISPLAY" ]; then \
	    $(PLAYER) demo/cornell-knot --animation polish; \
	else \
	    $(PLAYER) demo/cornell-knot --headless --animation polish --fps 12 --frames 'demo/polish/%04d.png' --contact-sheet demo/polish.png && \
	    $(PLAYER) demo/cornell-knot --headless --animation repaint --fps 12 --frames 'demo/repaint/%04d.png' --contact-sheet demo/repaint.png && \
	    echo "no display, so look at demo/polish.png and demo/repaint.png; single frames are in demo/polish and demo/repaint"; \
	fi
test: build  ## run every test, compile the fuzz targets, and without C what the player's core stands on; a missing GPU adapter is a failure
	cargo check --release -p relume-formats --no-default-features --features pure-rust-zstd
	cargo check --release -p relume-formats-fuzz -p relume-scenes-fuzz --features targets --bins --examples
	RELUME_REQUIRE_GPU=1 NODEVICE_SELECT=1 cargo test --release --workspace
test-long: test  ## run the slow tests too: soaks, many random scenes, whole charts, pictures of where methods fail; takes hours and the assets
	sh scenes/fetch-assets.sh
	RELUME_REQUIRE_GPU=1 NODEVICE_SELECT=1 cargo test --release --workspace -- --ignored --test-threads 1
fuzz:  ## run each fuzz target for SECONDS=600; needs a nightly toolchain and cargo-fuzz
	cargo run -q --release -p relume-formats-fuzz --example format_seeds
	cargo run -q --release -p relume-scenes-fuzz --example scene_seeds
	@set -e; export RUSTUP_AUTO_INSTALL=0; for dir in formats/fuzz scenes/fuzz; do for target in $$(cargo +nightly fuzz list --fuzz-dir $$dir); do \
	    cargo +nightly fuzz run --fuzz-dir $$dir --features libfuzzer $$target -- -max_total_time=$(SECONDS) -rss_limit_mb=1024 -timeout=20 -max_len=16384; done; done
sweep: build  ## compare what bake reads of some 500 models and maps of other people's packages with trimesh, into docs/notes/SWEEP.md; fetches 1 GB
	sh tests/sweep/fetch.sh && target/sweep/venv/bin/python -B tests/sweep/sweep.py $(BAKE)
bench: setup  ## time rays, cubes of texels, Haar transforms and triple products against other versions, frames of sphere-shadows on the CPU, reading of images, passes of the GPU beside copies, and frames of transfer-tensor
	cargo bench -p relume-bake --bench rays
	cargo bench -p relume-bake --bench cubes
	cargo bench -p relume-bake --bench haar
	cargo bench -p relume-formats --bench sphere_shadows
	cargo bench -p relume-formats --bench transfer_images
	cargo bench -p relume-playback --bench passes
	cargo bench -p relume-playback --bench tensors
lint: setup  ## formatting and lints, warnings are errors
	cargo fmt --all --check
	cargo clippy --release --workspace --all-targets -- -D warnings
