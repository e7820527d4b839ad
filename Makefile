# sgad: build, run, test. `make` builds build/sgad, build/sga and build/libsga.a.
#
#   make run      install what is missing, build, start a daemon, solve the arm, show it
#   make test     install what is missing, build, run every test; ends with N passed, N failed
#   make kill-test [ROUNDS=100]    kill -9 at random moments, nothing accepted is lost
#   make bench    ratios against peers in the same run (needs python3-sympy)
#   make SAN=address,undefined test      the same with sanitizers, in a build folder of its own
#   make FLOOR=ode unit                  only the unit tests of one folder of lib/

CC ?= gcc
SAN ?=
WERROR ?= 1
V ?=
Q := $(if $(V),,@)
comma := ,
B := build$(if $(SAN),-$(subst $(comma),-,$(SAN)))
OPT ?= -O2 -g
WARN := -Wall -Wextra -Wshadow -Wstrict-prototypes -Wmissing-prototypes -Wpointer-arith -Wvla $(if $(filter 1,$(WERROR)),-Werror)
CFLAGS ?= $(OPT)
ALL_CFLAGS := -std=gnu11 $(CFLAGS) $(WARN) $(if $(SAN),-fsanitize=$(SAN) -fno-omit-frame-pointer -fno-sanitize-recover=all) -ffp-contract=off -MMD -MP

# Floors: what each folder of lib/ may include. An include from a floor that is not
# listed does not compile, because only these folders are on the quote path.
DEPS_base    :=
DEPS_expr    := base
DEPS_sys     := expr base
DEPS_lin     := base
DEPS_num     := expr base
DEPS_pencil  := base
DEPS_poly    := expr base
DEPS_operator := expr base
DEPS_form    := sys expr base
DEPS_request := form sys expr base
DEPS_points  := lin num poly expr base
DEPS_sga     := points lin num poly sys expr base
DEPS_sym     := sga points lin num poly sys expr base
DEPS_graph   := base
DEPS_structure := sga graph points lin num poly sys expr base
DEPS_ode     := lin base
DEPS_enclose := num expr base
DEPS_traj    := enclose ode sga points lin num poly sys expr base
DEPS_mech    := sga points lin num poly form sys expr base
DEPS_run     := mech sym structure graph operator pencil traj enclose ode sga points lin num poly request form sys expr base
FLOORS := base graph expr sys lin pencil num poly operator form request points sga mech sym structure ode enclose traj run

# Programs see the public face of the library only.
SERVER_DEPS := run request form sys expr base
CLIENT_DEPS := run base

LIBS := -lcalcium -lflint-arb -lflint -lmpfr -lgmp -lklu -lamd -lcolamd -lbtf -lsuitesparseconfig -lgsl -lgslcblas -ljansson -lm
SERVER_LIBS := -lmicrohttpd -lsqlite3 -lgnutls -lseccomp -lpthread
CLIENT_LIBS :=

LIB_SRC := $(foreach f,$(FLOORS),$(wildcard lib/$(f)/*.c))
LIB_OBJ := $(LIB_SRC:%.c=$(B)/%.o)
SERVER_OBJ := $(patsubst %.c,$(B)/%.o,$(wildcard server/*.c)) $(B)/server/embedded.o
# The client takes results apart with the daemon's JSON scanner, and writes problems as the
# daemon does; it needs no JSON library.
CLIENT_OBJ := $(patsubst %.c,$(B)/%.o,$(wildcard clients/*.c)) $(B)/server/scan.o $(B)/server/problem.o

.PHONY: all lib run test unit bench kill-test clean deps check-deps
all: $(B)/sgad $(B)/sga $(B)/libsga.a
lib: $(B)/libsga.a

define floor_rules
$(B)/lib/$(1)/%.o: lib/$(1)/%.c
	@mkdir -p $$(@D)
	$(Q)$(CC) $(ALL_CFLAGS) -iquote lib/$(1) $(foreach d,$(DEPS_$(1)),-iquote lib/$(d)) -c $$< -o $$@
endef
$(foreach f,$(FLOORS),$(eval $(call floor_rules,$(f))))

$(B)/server/%.o: server/%.c
	@mkdir -p $(@D)
	$(Q)$(CC) $(ALL_CFLAGS) -iquote server $(foreach d,$(SERVER_DEPS),-iquote lib/$(d)) -c $< -o $@
# The schema is part of the program: it serves what it was built with.
EMBEDDED := $(sort $(wildcard schema/*.json))
$(B)/server/embedded.c: server/embed.sh $(EMBEDDED)
	@mkdir -p $(@D)
	sh server/embed.sh $(EMBEDDED) > $@
$(B)/server/embedded.o: $(B)/server/embedded.c server/embed.h
	$(Q)$(CC) $(ALL_CFLAGS) -iquote server -c $< -o $@
$(B)/clients/%.o: clients/%.c
	@mkdir -p $(@D)
	$(Q)$(CC) $(ALL_CFLAGS) -iquote clients -iquote server $(foreach d,$(CLIENT_DEPS),-iquote lib/$(d)) -c $< -o $@

$(B)/libsga.a: $(LIB_OBJ)
	@rm -f $@
	$(Q)ar rcs $@ $^
$(B)/sgad: $(SERVER_OBJ) $(B)/libsga.a
	$(Q)$(CC) $(ALL_CFLAGS) -o $@ $(SERVER_OBJ) $(B)/libsga.a $(LIBS) $(SERVER_LIBS)
$(B)/sga: $(CLIENT_OBJ) $(B)/libsga.a
	$(Q)$(CC) $(ALL_CFLAGS) -o $@ $(CLIENT_OBJ) $(B)/libsga.a $(LIBS) $(CLIENT_LIBS)

# Unit tests: tests/unit/FOLDER_what.c is linked with its folder's floors only.
UNIT_SRC := $(if $(FLOOR),$(wildcard tests/unit/$(FLOOR)_*.c),$(wildcard tests/unit/*.c))
UNIT_BIN := $(UNIT_SRC:tests/unit/%.c=$(B)/unit/%)
floor_of = $(firstword $(subst _, ,$(notdir $(1))))
floor_obj = $(foreach d,$(1) $(DEPS_$(1)),$(patsubst %.c,$(B)/%.o,$(wildcard lib/$(d)/*.c)))
define unit_rules
$(B)/unit/$(notdir $(basename $(1))): $(1) $(call floor_obj,$(call floor_of,$(1)))
	@mkdir -p $$(@D)
	$(Q)$(CC) $(ALL_CFLAGS) -iquote tests/unit $(foreach d,$(call floor_of,$(1)) $(DEPS_$(call floor_of,$(1))),-iquote lib/$(d)) -o $$@ $(1) $(call floor_obj,$(call floor_of,$(1))) $(LIBS)
endef
$(foreach u,$(wildcard tests/unit/*.c),$(eval $(call unit_rules,$(u))))
unit: $(UNIT_BIN)
	@for u in $(UNIT_BIN); do echo "# $$u"; $$u || exit 1; done

deps:
	@tests/setup
run: deps
	@$(MAKE) --no-print-directory all
	@tests/demo $(B)
test: deps
	@$(MAKE) --no-print-directory all $(UNIT_BIN)
	@tests/run $(B)
bench: deps
	@$(MAKE) --no-print-directory all
	@tests/bench/run $(B)
# The daemon killed a hundred times while clients post; the history they saw is checked.
kill-test: deps
	@$(MAKE) --no-print-directory all
	@PYTHONDONTWRITEBYTECODE=1 /usr/bin/python3 tests/api/kill.py $(B) $(or $(ROUNDS),100)
clean:
	rm -rf build build-*

-include $(LIB_OBJ:.o=.d) $(SERVER_OBJ:.o=.d) $(CLIENT_OBJ:.o=.d)
