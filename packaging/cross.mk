# Tools and libraries of another machine than this one (docs/same-bits.md), and the compiler by default.
# What is before a cross compiler's tools' names, and the folder that stands for / of the other machine.
ifeq ($(CONFIG),arm64)
CROSS ?= aarch64-linux-gnu-
SYSROOT ?= build/sysroot-arm64
endif
ifeq ($(origin CC),default)
CC := $(CROSS)gcc
endif
ifneq ($(CROSS),)
LD := $(CROSS)ld
AR := $(CROSS)ar
endif
ifneq ($(SYSROOT),)
override CC := $(CC) $(if $(findstring clang,$(CC)),--target=$(CROSS:-=)) --sysroot=$(abspath $(SYSROOT))
export PKG_CONFIG_SYSROOT_DIR := $(abspath $(SYSROOT))
export PKG_CONFIG_LIBDIR := $(SYSROOT)/usr/lib/$(CROSS:-=)/pkgconfig:$(SYSROOT)/usr/share/pkgconfig
endif

sysroot-arm64: ## get the libraries for CONFIG=arm64 into build/sysroot-arm64 (Debian; nothing is installed)
	@packaging/sysroot.sh build/sysroot-arm64 arm64
