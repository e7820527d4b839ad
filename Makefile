# sgad: build, run, test. `make` builds build/sgad, build/sga and build/libsga.a.
#
#   make install  programs, library, header, manual pages, clients, service files, examples: PREFIX=/usr/local, DESTDIR=
#   make deb      Debian packages: build/deb/*.deb
#   make shared   the library for other programs only: build/lib/libsga.so.0, build/lib/libsga.a
#   make python   the Python client as a wheel: build/python/
#   make run      install what is missing, build, start a daemon, solve the arm, show it
#   make test     install what is missing, build, run every test; ends with N passed, N failed
#   make quick    something about everything in a minute: samples of all suites
#   make lint     clang's warnings, gcc's analyzer where bytes from outside are read
#   make coverage [SUITES="unit cases"]     which lines the tests come by, by folder
#   make mutants [FOLDERS="sga traj"] [MUTANTS=40]     small errors put into the code: which ones no test sees
#   make deb-test [FULL=1]   two builds give the same bytes; the packages in a fresh Debian root: installed, run, upgraded, purged
#   make arm64-test          built for arm64 and run by qemu: the same answers as here, interpreted
#   make kill-test [ROUNDS=1000]   kill -9 at random moments, nothing accepted is lost
#   make chaos-test [JOBS=10000]   three daemons on one database under chaos: no accepted job lost, ended twice or mixed up
#   make faults-test [TURNS=1] [MINUTES=60] [IMAGES=300]   tests of the API with one call after the other failing; losses of power
#   make many-test [REQUESTS=100000]   no loss, duplicate or mix-up
#   make order-test [SEEDS=20]         the corpus in other words, each case with so many seeds
#   make soak-test [SECONDS=600]       memory does not grow
#   make fuzz [SECONDS=600]        mutated inputs, so long for each target
#   make bench    ratios against peers in the same run (needs python3-sympy; SUNDIALS is installed for it)
#   make SAN=address,undefined test      the same with sanitizers, in a build folder of its own
#   make FLOOR=ode unit                  only the unit tests of one folder of lib/

CC ?= gcc
SAN ?=
WERROR ?= 1
V ?=
Q := $(if $(V),,@)
comma := ,
B := build$(if $(SAN),-$(subst $(comma),-,$(SAN)))
# With sanitizers much sooner compiled than at -O2, and as fast.
OPT ?= $(if $(SAN),-O1 -g1,-O2 -g)
# No name of the folder in what is built, so that two folders give the same bytes; gcov wants it.
SAME := $(if $(findstring coverage,$(CFLAGS)),,-ffile-prefix-map=$(CURDIR)=.)
# gcc takes lengths of FLINT's contexts for too short where the thread sanitizer is on, and those of texts at -O1 with any.
WARN := $(if $(filter thread,$(SAN)),-Wno-stringop-overread) $(if $(SAN),-Wno-format-truncation -Wno-format-overflow) -Wall -Wextra -Wshadow -Wstrict-prototypes -Wmissing-prototypes -Wpointer-arith -Wvla $(if $(filter 1,$(WERROR)),-Werror)
CFLAGS ?= $(OPT)
ALL_CFLAGS := -std=gnu11 $(CPPFLAGS) $(CFLAGS) $(SAME) $(WARN) $(if $(SAN),-fsanitize=$(SAN) -fno-omit-frame-pointer -fno-sanitize-recover=all) -ffp-contract=off -fPIC -fvisibility=hidden -MMD -MP

# Floors: what each folder of lib/ may include. An include from a floor that is not
# listed does not compile, because only these folders are on the quote path.
DEPS_base    :=
DEPS_exact   := base
DEPS_expr    := base
DEPS_sys     := expr base
DEPS_lin     := base
DEPS_num     := lin expr base
DEPS_pencil  := base
DEPS_poly    := expr base
DEPS_operator := expr base
DEPS_form    := sys expr base
DEPS_request := form sys expr base
DEPS_families := request form sys expr base
DEPS_points  := graph lin num poly expr base
DEPS_sga     := exact points graph lin num poly sys expr base
DEPS_sym     := sga exact points graph lin num poly sys expr base
DEPS_graph   := base
DEPS_plot    := base
DEPS_fit     := base
DEPS_export  := expr base
DEPS_structure := sga exact graph points lin num poly sys expr base
DEPS_guard   := base
DEPS_ode     := guard lin base
DEPS_enclose := num lin expr base
# A motion's rooms, from what is asked (problem) up to motions in pieces between events; one motion from request to samples on top.
BELOW_traj   := enclose ode guard sga exact points graph lin num poly sys expr base
DEPS_traj/problem := $(BELOW_traj)
DEPS_traj/manifold := traj/problem $(BELOW_traj)
DEPS_traj/field := traj/manifold $(DEPS_traj/manifold)
DEPS_traj/flow := traj/field $(DEPS_traj/field)
DEPS_traj/enclosed := traj/flow $(DEPS_traj/flow)
DEPS_traj/start := traj/enclosed $(DEPS_traj/enclosed)
DEPS_traj/variation := traj/start $(DEPS_traj/start)
DEPS_traj/precise := traj/flow $(DEPS_traj/flow)
DEPS_traj/arithmetic := traj/precise $(DEPS_traj/precise)
DEPS_traj/jump := traj/field $(DEPS_traj/field)
DEPS_traj/crossing := traj/jump traj/precise $(DEPS_traj/precise)
DEPS_traj/pieces := traj/crossing traj/jump traj/precise traj/enclosed $(DEPS_traj/enclosed)
TRAJ := traj/pieces traj/crossing traj/jump traj/arithmetic traj/precise traj/variation traj/start traj/enclosed traj/flow traj/field traj/manifold traj/problem
DEPS_traj    := $(TRAJ) $(BELOW_traj)
DEPS_linear  := pencil sga exact points graph lin num poly sys expr base
DEPS_dirac   := sga exact points graph lin num poly sys expr base
DEPS_mech    := sga exact points graph lin num poly form sys expr base
# A request's rooms: its stages in the order in which they run, above what all of them are about (job); the table of stages on top.
DEPS_face    := run base
BELOW_run    := fit dirac linear mech sym structure graph operator pencil traj $(TRAJ) enclose ode guard sga exact points lin num poly request form sys expr base
DEPS_run/job := $(BELOW_run)
DEPS_run/model := run/job $(BELOW_run)
DEPS_run/slice := run/job $(BELOW_run)
DEPS_run/texts := run/slice run/model run/job $(BELOW_run)
DEPS_run/strata := run/texts run/model run/job $(BELOW_run)
DEPS_run/properties := run/strata run/texts run/model run/job $(BELOW_run)
DEPS_run/motion := run/model run/job $(BELOW_run)
DEPS_run/ask := run/motion run/job $(BELOW_run)
DEPS_run/derivation := run/ask run/texts run/model run/job export $(BELOW_run)
DEPS_run/dirac := run/ask run/model run/job $(BELOW_run)
DEPS_run/tradeoff := run/motion run/job $(BELOW_run)
DEPS_run/write := families export run/dirac run/derivation run/ask run/tradeoff run/motion run/properties run/strata run/texts run/slice run/model run/job $(BELOW_run)
DEPS_run/sweep := run/write run/motion run/strata run/model run/job $(BELOW_run)
DEPS_run/vary := run/sweep $(DEPS_run/write) run/write
DEPS_run/follow := run/vary run/sweep $(DEPS_run/write) run/write
DEPS_run     := run/follow $(DEPS_run/follow)
FLOORS := base exact fit plot graph guard expr export sys lin pencil num poly operator form request families points sga dirac linear mech sym structure ode enclose traj/problem traj/manifold traj/field traj/flow traj/enclosed traj/start traj/variation traj/precise traj/arithmetic traj/jump traj/crossing traj/pieces traj run/job run/model run/slice run/texts run/strata run/properties run/motion run/ask run/derivation run/dirac run/tradeoff run/write run/sweep run/vary run/follow run face

# The floors of server/, in the same way; of the library they see the public face. main.c sees all of them.
DEPS_tools     := base
DEPS_settings  :=
DEPS_formats   := tools plot families export request form sys expr base
DEPS_records   := tools base
DEPS_store     := records tools base
DEPS_postgres  := store records tools base
DEPS_child     := settings tools run base
DEPS_jobs      := child store records settings tools run base
DEPS_access    := jobs postgres store records settings tools base
DEPS_framing   := base
DEPS_net       := framing settings base
DEPS_exchange  := child net access jobs store records settings tools run base
DEPS_handlers  := formats families export exchange net access jobs store records settings tools run base
DEPS_http      := handlers exchange net access jobs store records settings tools base
DEPS_admin     := access postgres store records settings tools base
SERVER_FLOORS := tools settings formats records store postgres child jobs access framing net exchange handlers http admin
SERVER_DEPS := $(SERVER_FLOORS) run base
CLIENT_DEPS := formats tools run plot families export base

# Folders of server/ or lib/ as places that includes are looked for in.
quote = $(foreach d,$(1),-iquote $(if $(filter $(d),$(SERVER_FLOORS)),server,lib)/$(d))

LIBS := -lflint-arb -lflint -lmpfr -lgmp -lklu -lldl -lamd -lcolamd -lbtf -lsuitesparseconfig -lgsl -lgslcblas -ljansson -lm
# A store that daemons share needs libpq; POSTGRES= builds without, and so it is where libpq-dev is not installed.
POSTGRES ?= $(if $(wildcard /usr/include/postgresql/libpq-fe.h),1)
SERVER_LIBS := -lmicrohttpd -lsqlite3 -lgnutls -lseccomp -lz -lpthread $(if $(POSTGRES),-lpq)
CLIENT_LIBS := -lz -ldl

LIB_SRC := $(foreach f,$(FLOORS),$(wildcard lib/$(f)/*.c))
LIB_OBJ := $(LIB_SRC:%.c=$(B)/%.o) $(B)/lib/run/version.o $(B)/lib/export/fmu_runtime.o
ABSENT := $(if $(POSTGRES),server/postgres/absent.c,$(filter-out server/postgres/absent.c,$(wildcard server/postgres/*.c)))
SERVER_SRC := server/main.c $(filter-out $(ABSENT),$(foreach f,$(SERVER_FLOORS),$(wildcard server/$(f)/*.c)))
STEPS_OBJ := $(if $(POSTGRES),$(B)/server/pg_steps.o)
SERVER_OBJ := $(SERVER_SRC:%.c=$(B)/%.o) $(B)/server/embedded.o $(B)/server/page_files.o $(STEPS_OBJ)
# The client takes results apart with the daemon's JSON scanner, and writes problems as the
# daemon does; it needs no JSON library. A tradeoff is shown by the same code too.
CLIENT_OBJ := $(patsubst %.c,$(B)/%.o,$(wildcard clients/*.c)) $(addprefix $(B)/server/,tools/json_scan.o tools/json_string.o tools/spool.o) $(patsubst %.c,$(B)/%.o,$(wildcard server/formats/*.c))

.PHONY: all lib python shared install uninstall deb deb-test arm64-test FORCE run test quick units lint coverage mutants unit bench kill-test chaos-test faults-test many-test order-test soak-test fuzz fuzz-build clean deps check-deps
all: $(B)/sgad $(B)/sga $(B)/libsga.a
lib: $(B)/libsga.a
# The Python client as a wheel, by the standard library alone.
python:
	@/usr/bin/python3 clients/python/backend.py $(B)/python

# Objects of other flags are none of these.
$(B)/flags: FORCE
	@mkdir -p $(@D)
	@echo '$(CC) $(ALL_CFLAGS)' | cmp -s - $@ || echo '$(CC) $(ALL_CFLAGS)' > $@
FORCE:

define floor_rules
$(B)/lib/$(1)/%.o: lib/$(1)/%.c $(B)/flags
	@mkdir -p $$(@D)
	$(Q)$(CC) $(ALL_CFLAGS) -iquote lib/$(1) $(foreach d,$(DEPS_$(1)),-iquote lib/$(d)) -c $$< -o $$@
endef
$(foreach f,$(FLOORS),$(eval $(call floor_rules,$(f))))

define server_rules
$(B)/server/$(1)/%.o: server/$(1)/%.c $(B)/flags
	@mkdir -p $$(@D)
	$(Q)$(CC) $(ALL_CFLAGS) $(call quote,$(1) $(DEPS_$(1))) $(if $(filter postgres,$(1)),-isystem /usr/include/postgresql) -c $$< -o $$@
endef
$(foreach f,$(SERVER_FLOORS),$(eval $(call server_rules,$(f))))
# The steps of the database's schema are part of the program too.
STEPS := $(sort $(wildcard server/postgres/schema-*.sql))
$(B)/server/pg_steps.c: server/postgres/steps.sh $(STEPS)
	@mkdir -p $(@D)
	@sh server/postgres/steps.sh $(STEPS) > $@
$(B)/server/pg_steps.o: $(B)/server/pg_steps.c server/postgres/pg_steps.h
	$(Q)$(CC) $(ALL_CFLAGS) $(call quote,postgres) -c $< -o $@
$(B)/server/main.o: server/main.c $(B)/flags
	@mkdir -p $(@D)
	$(Q)$(CC) $(ALL_CFLAGS) $(call quote,$(SERVER_DEPS)) -c $< -o $@
# The schema is part of the program: it serves what it was built with.
EMBEDDED := $(sort $(wildcard schema/*.json))
$(B)/server/embedded.c: server/handlers/embed.sh $(EMBEDDED)
	@mkdir -p $(@D)
	sh server/handlers/embed.sh $(EMBEDDED) > $@
# So is the page: its files as they are, and packed.
PAGE := $(sort $(wildcard clients/page/*.html clients/page/*.css clients/page/*.js clients/page/*.svg clients/page/uplot/*.js clients/page/uplot/*.css etc/examples/*.json))
$(B)/server/page_files.c: server/handlers/page.sh $(PAGE)
	@mkdir -p $(@D)
	sh server/handlers/page.sh $(PAGE) > $@ || { rm -f $@; exit 1; }
$(B)/server/page_files.o: $(B)/server/page_files.c server/handlers/page_files.h
	$(Q)$(CC) $(ALL_CFLAGS) $(call quote,handlers) -c $< -o $@
$(B)/server/embedded.o: $(B)/server/embedded.c server/handlers/embed.h
	$(Q)$(CC) $(ALL_CFLAGS) $(call quote,handlers) -c $< -o $@
$(B)/clients/%.o: clients/%.c $(B)/flags
	@mkdir -p $(@D)
	$(Q)$(CC) $(ALL_CFLAGS) -iquote clients $(call quote,$(CLIENT_DEPS)) -c $< -o $@

# The version changes with everything that answers come from: old ones are not given for new ones.
VERSION := 0.3.0
ANSWERS := $(sort $(foreach f,$(FLOORS),$(wildcard lib/$(f)/*.[ch] lib/$(f)/*.def)))
$(B)/lib/run/version.c: lib/run/version.sh Makefile $(ANSWERS)
	@mkdir -p $(@D)
	@sh lib/run/version.sh $(VERSION) $(ANSWERS) > $@
$(B)/lib/run/version.o: $(B)/lib/run/version.c
	$(Q)$(CC) $(ALL_CFLAGS) -iquote lib/face -c $< -o $@

# The C that every FMU has, as a text of the program.
FMU_PARTS := $(patsubst %,lib/export/fmu_%.c.in,instance integrator values steps)
$(B)/lib/export/fmu_runtime.c: $(FMU_PARTS) Makefile
	@mkdir -p $(@D)
	@{ echo '#include "fmu_parts.h"'; echo 'const char fmu_runtime[] ='; sed -e 's/\\/\\\\/g' -e 's/"/\\"/g' -e 's/^/"/' -e 's/$$/\\n"/' $(FMU_PARTS); echo ';'; } > $@
$(B)/lib/export/fmu_runtime.o: $(B)/lib/export/fmu_runtime.c lib/export/fmu_parts.h
	$(Q)$(CC) $(ALL_CFLAGS) -iquote lib/export -iquote lib/expr -iquote lib/base -c $< -o $@

$(B)/libsga.a: $(LIB_OBJ)
	@rm -f $@
	$(Q)ar rcsD $@ $^
$(B)/sgad: $(SERVER_OBJ) $(B)/libsga.a
	$(Q)$(CC) $(ALL_CFLAGS) $(LDFLAGS) -o $@ $(SERVER_OBJ) $(B)/libsga.a $(LIBS) $(SERVER_LIBS)
$(B)/sga: $(CLIENT_OBJ) $(B)/libsga.a
	$(Q)$(CC) $(ALL_CFLAGS) $(LDFLAGS) -o $@ $(CLIENT_OBJ) $(B)/libsga.a $(LIBS) $(CLIENT_LIBS)

# For other programs: what lib/face/sga.h declares, and no other name. The static library is one object, so that its inner names are
# nobody's: with lists of libraries only (LIBS) it needs no others.
MAP := lib/face/sga.map
SOVERSION := 0
PUBLIC := $(shell sed -n 's/^ *\(sga_[a-z_]*\);$$/\1/p' $(MAP))
shared: $(B)/lib/libsga.so.$(VERSION) $(B)/lib/libsga.a
$(B)/lib/libsga.so.$(VERSION): $(LIB_OBJ) $(MAP)
	$(Q)$(CC) $(ALL_CFLAGS) $(LDFLAGS) -shared -Wl,-soname,libsga.so.$(SOVERSION) -Wl,--version-script=$(MAP) -Wl,-z,defs -o $@ $(LIB_OBJ) $(LIBS) -lpthread
	@ln -sf libsga.so.$(VERSION) $(B)/lib/libsga.so.$(SOVERSION)
	@ln -sf libsga.so.$(SOVERSION) $(B)/lib/libsga.so
$(B)/lib/libsga.a: $(LIB_OBJ) $(MAP)
	@rm -f $@
	$(Q)ld -r -o $(B)/lib/libsga.o $(LIB_OBJ)
	$(Q)objcopy $(PUBLIC:%=--keep-global-symbol=%) $(B)/lib/libsga.o
	$(Q)ar rcsD $@ $(B)/lib/libsga.o

PREFIX ?= /usr/local
DESTDIR ?=
BINDIR ?= $(PREFIX)/bin
LIBDIR ?= $(PREFIX)/lib
INCLUDEDIR ?= $(PREFIX)/include
MANDIR ?= $(PREFIX)/share/man
DOCDIR ?= $(PREFIX)/share/doc/sga
COMPLETIONS ?= $(PREFIX)/share/bash-completion/completions
DATADIR ?= $(PREFIX)/share/sga
# Of the system where it is the system's: else below PREFIX, and units name the programs where they are.
SYSCONFDIR ?= $(if $(filter /usr,$(PREFIX)),/etc,$(PREFIX)/etc)
UNITDIR ?= $(PREFIX)/lib/systemd/system
SYSUSERSDIR ?= $(PREFIX)/lib/sysusers.d
TMPFILESDIR ?= $(PREFIX)/lib/tmpfiles.d
# Where Debian's Python and Octave look; a file for Julia is included by its path.
PYTHONDIR ?= $(PREFIX)/lib/python$(if $(filter /usr,$(PREFIX)),3,$(shell /usr/bin/python3 -c 'import sys; print("%d.%d" % sys.version_info[:2])'))/dist-packages
OCTAVEDIR ?= $(PREFIX)/share/octave/site/m
JULIADIR ?= $(DATADIR)/julia
WHEEL := $(B)/python/sga_client-$(VERSION)-py3-none-any.whl
MAN := $(wildcard etc/man/*)
install: all shared python
	install -d $(DESTDIR)$(BINDIR) $(DESTDIR)$(LIBDIR)/pkgconfig $(DESTDIR)$(INCLUDEDIR) $(DESTDIR)$(DOCDIR)/doc $(DESTDIR)$(DOCDIR)/examples $(DESTDIR)$(DOCDIR)/schema
	install $(B)/sgad $(B)/sga $(DESTDIR)$(BINDIR)
	install -m 644 $(B)/lib/libsga.so.$(VERSION) $(B)/lib/libsga.a $(DESTDIR)$(LIBDIR)
	ln -sf libsga.so.$(VERSION) $(DESTDIR)$(LIBDIR)/libsga.so.$(SOVERSION)
	ln -sf libsga.so.$(SOVERSION) $(DESTDIR)$(LIBDIR)/libsga.so
	install -m 644 lib/face/sga.h $(DESTDIR)$(INCLUDEDIR)
	sed -e 's|@LIBDIR@|$(LIBDIR)|; s|@INCLUDEDIR@|$(INCLUDEDIR)|; s|@VERSION@|$(VERSION)|; s|@LIBS@|$(LIBS) -lpthread|' etc/sga.pc.in > $(DESTDIR)$(LIBDIR)/pkgconfig/sga.pc
	for m in $(MAN); do install -d $(DESTDIR)$(MANDIR)/man$${m##*.} && install -m 644 $$m $(DESTDIR)$(MANDIR)/man$${m##*.} || exit 1; done
	install -d $(DESTDIR)$(COMPLETIONS) && install -m 644 etc/completion/sga $(DESTDIR)$(COMPLETIONS)/sga && ln -sf sga $(DESTDIR)$(COMPLETIONS)/sgad
	install -m 644 README.md CHANGELOG.md LICENSE $(DESTDIR)$(DOCDIR)
	install -m 644 doc/*.md $(DESTDIR)$(DOCDIR)/doc
	install -m 644 schema/*.json $(DESTDIR)$(DOCDIR)/schema
	install -m 644 etc/examples/*.json etc/examples/*.c etc/examples/*.cir etc/examples/*.mo etc/examples/*.m $(DESTDIR)$(DOCDIR)/examples
	install -d $(DESTDIR)$(UNITDIR) $(DESTDIR)$(SYSUSERSDIR) $(DESTDIR)$(TMPFILESDIR) $(DESTDIR)$(SYSCONFDIR)
	for f in sgad.service sgad.socket; do sed -e 's|/usr/bin/sgad|$(BINDIR)/sgad|; s|/etc/sgad.conf|$(SYSCONFDIR)/sgad.conf|' etc/$$f > $(DESTDIR)$(UNITDIR)/$$f && chmod 644 $(DESTDIR)$(UNITDIR)/$$f || exit 1; done
	install -m 644 etc/sgad.sysusers $(DESTDIR)$(SYSUSERSDIR)/sgad.conf
	install -m 644 etc/sgad.tmpfiles $(DESTDIR)$(TMPFILESDIR)/sgad.conf
	test -e $(DESTDIR)$(SYSCONFDIR)/sgad.conf || install -m 644 etc/sgad.conf $(DESTDIR)$(SYSCONFDIR)
	for d in prometheus grafana proxy; do install -d $(DESTDIR)$(DATADIR)/$$d && install -m 644 etc/$$d/* $(DESTDIR)$(DATADIR)/$$d || exit 1; done
	install -d $(DESTDIR)$(OCTAVEDIR)/+sga && install -m 644 clients/octave/+sga/*.m $(DESTDIR)$(OCTAVEDIR)/+sga
	install -d $(DESTDIR)$(JULIADIR) && install -m 644 clients/julia/SgaClient.jl $(DESTDIR)$(JULIADIR)
	install -d $(DESTDIR)$(PYTHONDIR) && /usr/bin/python3 -m zipfile -e $(WHEEL) $(DESTDIR)$(PYTHONDIR) && chmod -R u=rwX,go=rX $(DESTDIR)$(PYTHONDIR)/sga $(DESTDIR)$(PYTHONDIR)/sga_client-*.dist-info
# Settings that were changed stay.
uninstall:
	rm -f $(DESTDIR)$(BINDIR)/sgad $(DESTDIR)$(BINDIR)/sga $(DESTDIR)$(LIBDIR)/libsga.* $(DESTDIR)$(LIBDIR)/pkgconfig/sga.pc $(DESTDIR)$(INCLUDEDIR)/sga.h
	for m in $(MAN); do rm -f $(DESTDIR)$(MANDIR)/man$${m##*.}/$${m##*/} || exit 1; done
	rm -f $(DESTDIR)$(COMPLETIONS)/sga $(DESTDIR)$(COMPLETIONS)/sgad
	rm -rf $(DESTDIR)$(DOCDIR) $(DESTDIR)$(DATADIR) $(DESTDIR)$(OCTAVEDIR)/+sga $(DESTDIR)$(PYTHONDIR)/sga $(DESTDIR)$(PYTHONDIR)/sga_client-$(VERSION).dist-info
	rm -f $(DESTDIR)$(UNITDIR)/sgad.service $(DESTDIR)$(UNITDIR)/sgad.socket $(DESTDIR)$(SYSUSERSDIR)/sgad.conf $(DESTDIR)$(TMPFILESDIR)/sgad.conf
	! cmp -s etc/sgad.conf $(DESTDIR)$(SYSCONFDIR)/sgad.conf || rm -f $(DESTDIR)$(SYSCONFDIR)/sgad.conf

# Debian packages, from a copy of the sources: what the top level has, and etc/debian as debian/.
DEB ?= $(B)/deb
TOP := Makefile README.md CHANGELOG.md LICENSE server lib schema tests clients etc doc
deb:
	@rm -rf $(DEB)
	@mkdir -p $(DEB)/sgad-$(VERSION)
	@cp -r $(TOP) $(DEB)/sgad-$(VERSION) && find $(DEB)/sgad-$(VERSION) -name __pycache__ -prune -exec rm -rf {} +
	@mv $(DEB)/sgad-$(VERSION)/etc/debian $(DEB)/sgad-$(VERSION)/debian
	@chmod -R u=rwX,go=rX $(DEB)/sgad-$(VERSION)          # whatever the umask
	cd $(DEB)/sgad-$(VERSION) && unset MAKEFLAGS MFLAGS MAKELEVEL && DEB_BUILD_OPTIONS="$${DEB_BUILD_OPTIONS:-parallel=2}" dpkg-buildpackage --no-sign $(if $(BINARY_ONLY),--build=binary)
	@rm -rf $(DEB)/sgad-$(VERSION)
deb-test:
	@tests/setup deb
	@PYTHONDONTWRITEBYTECODE=1 /usr/bin/python3 tests/deb_root.py $(B)
arm64-test:
	@tests/setup arm64
	@PYTHONDONTWRITEBYTECODE=1 /usr/bin/python3 tests/arm64_check.py $(B)

# Unit tests: tests/unit/FOLDER_what.c is linked with its folder's floors only.
UNIT_SRC := $(if $(FLOOR),$(wildcard tests/unit/$(FLOOR)_*.c),$(wildcard tests/unit/*.c))
UNIT_BIN := $(UNIT_SRC:tests/unit/%.c=$(B)/unit/%)
# FLOOR_memory.c stands between the code and malloc, to let allocations fail.
FAILING := -Wl,--wrap=malloc,--wrap=calloc,--wrap=realloc
floor_of = $(firstword $(subst _, ,$(notdir $(1))))
floor_obj = $(foreach d,$(1) $(DEPS_$(1)),$(patsubst %.c,$(B)/%.o,$(wildcard lib/$(d)/*.c server/$(d)/*.c))) $(if $(filter run,$(1)),$(B)/lib/run/version.o) $(if $(filter export,$(1) $(DEPS_$(1))),$(B)/lib/export/fmu_runtime.o)
define unit_rules
$(B)/unit/$(notdir $(basename $(1))): $(1) $(call floor_obj,$(call floor_of,$(1))) $(if $(filter jobs,$(call floor_of,$(1))),$(B)/libsga.a)
	@mkdir -p $$(@D)
	$(Q)$(CC) $(ALL_CFLAGS) -iquote tests/unit $(call quote,$(call floor_of,$(1)) $(DEPS_$(call floor_of,$(1)))) -o $$@ $(1) $(call floor_obj,$(call floor_of,$(1))) $(if $(filter jobs,$(call floor_of,$(1))),$(B)/libsga.a) $(LIBS) $(if $(filter jobs tools,$(call floor_of,$(1))),$(SERVER_LIBS)) $(if $(findstring _memory,$(1)),$(FAILING))
endef
$(foreach u,$(wildcard tests/unit/*.c),$(eval $(call unit_rules,$(u))))
# What every store promises, asked of the one that is named: the folders of server/ that it needs, and no others.
STORE_FLOORS := store postgres records tools
STORE_OBJ := $(patsubst %.c,$(B)/%.o,$(filter-out $(ABSENT),$(foreach f,$(STORE_FLOORS),$(wildcard server/$(f)/*.c)))) $(STEPS_OBJ)
CONFORMANCE := $(wildcard tests/conformance/*.c)
$(B)/conformance: $(CONFORMANCE) tests/conformance/orders.h tests/unit/check.h $(STORE_OBJ) $(B)/libsga.a
	$(Q)$(CC) $(filter-out -MMD -MP,$(ALL_CFLAGS)) -iquote tests/conformance -iquote tests/unit $(call quote,$(STORE_FLOORS) base) -o $@ $(CONFORMANCE) $(STORE_OBJ) $(B)/libsga.a $(LIBS) $(SERVER_LIBS)
units: $(UNIT_BIN) $(B)/conformance
unit: $(UNIT_BIN)
	@for u in $(UNIT_BIN); do echo "# $$u"; $$u || exit 1; done

# Fuzz targets: tests/fuzz/NAME.c with what it is about compiled once more, so that edges are
# counted; the rest comes from the library. With clang, `make CC=clang WERROR=0 LIBFUZZER=1
# SAN=address,undefined,fuzzer-no-link fuzz-build` links them with libFuzzer instead of driver.c.
FUZZ := expression request admission store
FUZZ_FLAGS := $(ALL_CFLAGS) $(if $(LIBFUZZER),,-fsanitize-coverage=trace-pc)
FUZZ_OBJ := $(foreach d,request $(DEPS_request),$(patsubst %.c,$(B)/fuzz/%.o,$(wildcard lib/$(d)/*.c)))
FUZZ_SERVER_OBJ := $(patsubst %.c,$(B)/fuzz/%.o,$(filter-out server/main.c,$(SERVER_SRC))) $(B)/server/embedded.o $(B)/server/page_files.o $(STEPS_OBJ)
define fuzz_floor_rules
$(B)/fuzz/lib/$(1)/%.o: lib/$(1)/%.c
	@mkdir -p $$(@D)
	$(Q)$(CC) $(FUZZ_FLAGS) -iquote lib/$(1) $(foreach d,$(DEPS_$(1)),-iquote lib/$(d)) -c $$< -o $$@
endef
$(foreach f,request $(DEPS_request),$(eval $(call fuzz_floor_rules,$(f))))
define fuzz_server_rules
$(B)/fuzz/server/$(1)/%.o: server/$(1)/%.c
	@mkdir -p $$(@D)
	$(Q)$(CC) $(FUZZ_FLAGS) $(call quote,$(1) $(DEPS_$(1))) $(if $(filter postgres,$(1)),-isystem /usr/include/postgresql) -c $$< -o $$@
endef
$(foreach f,$(SERVER_FLOORS),$(eval $(call fuzz_server_rules,$(f))))
$(B)/fuzz/%.o: tests/fuzz/%.c
	@mkdir -p $(@D)
	$(Q)$(CC) $(ALL_CFLAGS) -iquote tests/fuzz $(call quote,$(SERVER_DEPS) request form sys expr) -c $< -o $@
$(B)/fuzz/expression $(B)/fuzz/request: $(B)/fuzz/%: $(B)/fuzz/%.o $(FUZZ_OBJ)
$(B)/fuzz/admission $(B)/fuzz/store: $(B)/fuzz/%: $(B)/fuzz/%.o $(FUZZ_SERVER_OBJ) $(FUZZ_OBJ)
$(FUZZ:%=$(B)/fuzz/%): $(if $(LIBFUZZER),,$(B)/fuzz/driver.o) $(B)/libsga.a
	$(Q)$(CC) $(ALL_CFLAGS) $(if $(LIBFUZZER),-fsanitize=fuzzer) -o $@ $(filter %.o,$^) $(B)/libsga.a $(LIBS) $(SERVER_LIBS)
fuzz-build: $(FUZZ:%=$(B)/fuzz/%)

deps:
	@tests/setup
run: deps
	@$(MAKE) --no-print-directory all
	@tests/demo $(B)
test: deps
	@$(MAKE) --no-print-directory all units
	@tests/run $(B)
quick: deps
	@$(MAKE) --no-print-directory all units
	@SGA_TEST_SCALE=0.02 SGA_TEST_EVERY=20 tests/run $(B) unit self schema work cases hard errors units tables cut order exact operator symmetry service
# What a second compiler sees; and gcc's analyzer on the floors that read what strangers send.
lint: deps
	@tests/lint
coverage: deps
	@$(MAKE) --no-print-directory WERROR=0 B=build-coverage CFLAGS="-O1 -g --coverage -fprofile-update=atomic" all units
	@find build-coverage -name '*.gcda' -delete
	@tests/run build-coverage $(or $(SUITES),unit self cases hard parameters operator mechanical symmetry linearization equilibria dirac derivation export sensitivities fit switches tables enclosures errors store service) | tail -n 30
	@/usr/bin/python3 tests/coverage.py build-coverage --write
mutants: deps
	@/usr/bin/python3 tests/mutate.py build-mutants $(or $(MUTANTS),40) $(FOLDERS)
bench: deps
	@$(MAKE) --no-print-directory all
	@tests/bench/run $(B)
# The daemon killed a thousand times while clients post; the history they saw is checked.
kill-test: deps
	@$(MAKE) --no-print-directory all
	@PYTHONDONTWRITEBYTECODE=1 /usr/bin/python3 tests/api/kill.py $(B) $(or $(ROUNDS),1000)
# Tests of the API with one write, sync, open, process, allocation, look at the clock or line of the log after the other failing (TURNS
# of each for each test; 0: all); and disks as losses of power leave them.
faults-test: deps
	@$(MAKE) --no-print-directory all
	@PYTHONDONTWRITEBYTECODE=1 /usr/bin/python3 tests/api/power.py $(B) $(or $(IMAGES),300)
	@PYTHONDONTWRITEBYTECODE=1 /usr/bin/python3 tests/api/turns.py $(B) $(or $(TURNS),1) $(or $(MINUTES),60)
# Three daemons on one PostgreSQL, killed, stopped, cut off and stalled, its server crashed and replaced by its standby, until JOBS were accepted.
chaos-test: deps
	@$(MAKE) --no-print-directory all
	@PYTHONDONTWRITEBYTECODE=1 /usr/bin/python3 tests/api/chaos.py $(B) $(or $(JOBS),10000)
# A hundred thousand requests with no loss, duplicate or mix-up; a long time in which memory
# does not grow.
many-test: deps
	@$(MAKE) --no-print-directory all
	@PYTHONDONTWRITEBYTECODE=1 /usr/bin/python3 tests/api/load.py $(B) many $(or $(REQUESTS),100000)
# Every case of the corpus asked in other words: nothing of an answer may move.
order-test: deps
	@$(MAKE) --no-print-directory all
	@PYTHONDONTWRITEBYTECODE=1 SGA_TEST_SEEDS=$(or $(SEEDS),20) /usr/bin/python3 tests/order_check.py $(B)
soak-test: deps
	@$(MAKE) --no-print-directory all
	@PYTHONDONTWRITEBYTECODE=1 /usr/bin/python3 tests/api/load.py $(B) soak $(or $(SECONDS),600)
# Mutated inputs for so many seconds each, under the address and undefined-behaviour sanitizers.
fuzz: deps
	@$(MAKE) --no-print-directory SAN=address,undefined fuzz-build
	@tests/fuzz/run build-address-undefined $(or $(SECONDS),600)
clean:
	rm -rf build build-*

-include $(LIB_OBJ:.o=.d) $(SERVER_OBJ:.o=.d) $(CLIENT_OBJ:.o=.d) $(FUZZ_OBJ:.o=.d) $(FUZZ_SERVER_OBJ:.o=.d) $(FUZZ:%=$(B)/fuzz/%.d)
