# `make demo` and `make test` are all that a fresh machine with cargo needs; each does its own set-up.
.DEFAULT_GOAL := help
SCENE ?= cornell-knot
ANIMATION ?= polish
BAKE = target/release/bake
PLAYER = target/release/player
.PHONY: help setup build assets bake play demo test lint

help:   ## list the targets
	@grep -E '^[a-z]+: .*##' $(MAKEFILE_LIST) | sed -E 's/:.*## /\t/' | expand -t 10
setup:  ## install missing system libraries, or say which are missing
	@sh .ci/setup
build: setup  ## build both programs
	cargo build --release --workspace
assets:  ## fetch the pinned third-party assets
	sh scenes/fetch-assets.sh
bake: build  ## bake SCENE=<name> into baked/<name>
	@if grep -qs '"assets/' scenes/library/$(SCENE)/scene.toml; then sh scenes/fetch-assets.sh; fi
	$(BAKE) run $(SCENE)
play: build  ## play SCENE=<name> [ANIMATION=<name>] to frames and a contact sheet in baked/
	$(PLAYER) baked/$(SCENE) --headless --animation $(ANIMATION) --fps 12 --frames 'baked/frames/$(SCENE)-$(ANIMATION)/%04d.png' --contact-sheet baked/frames/$(SCENE)-$(ANIMATION).png
	@echo "look at baked/frames/$(SCENE)-$(ANIMATION).png; single frames are in baked/frames/$(SCENE)-$(ANIMATION)"
demo: build  ## bake a small scene and play its animations to pictures in demo/
	$(BAKE) run cornell-knot --quality final -o demo/cornell-knot
	$(PLAYER) demo/cornell-knot --headless --animation polish --fps 12 --frames 'demo/polish/%04d.png' --contact-sheet demo/polish.png
	$(PLAYER) demo/cornell-knot --headless --animation repaint --fps 12 --frames 'demo/repaint/%04d.png' --contact-sheet demo/repaint.png
	@echo "look at demo/polish.png and demo/repaint.png; single frames are in demo/polish and demo/repaint"
test: build  ## run every test; a missing GPU adapter is a failure
	RELUME_REQUIRE_GPU=1 NODEVICE_SELECT=1 cargo test --release --workspace
lint: setup  ## formatting and lints, warnings are errors
	cargo fmt --all --check
	cargo clippy --release --workspace --all-targets -- -D warnings
