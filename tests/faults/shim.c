/* Counts the calls with which a program changes the disk, and lets one of them fail or be the last.
 *
 * FAULT_KIND  fail: this call fails; full: this one and all later ones that take space; kill: the program is killed before it;
 *             torn: it is killed after half of a write
 * FAULT_AT    which call, from 1
 * FAULT_LOG   a file that gets the number of calls at the end
 */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <stdarg.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/uio.h>
#include <unistd.h>

static atomic_long calls;
static long at;
static const char *kind = "";

__attribute__((constructor)) static void begin(void) {
    const char *text = getenv("FAULT_AT");
    at = text ? atol(text) : 0;
    if (getenv("FAULT_KIND")) kind = getenv("FAULT_KIND");
}

__attribute__((destructor)) static void end(void) {
    const char *path = getenv("FAULT_LOG");
    if (!path) return;
    char text[32];
    int length = snprintf(text, sizeof text, "%ld", (long)calls);
    int file = syscall(SYS_openat, AT_FDCWD, path, O_WRONLY | O_CREAT | O_TRUNC, 0644);
    if (file >= 0 && syscall(SYS_write, file, text, length) < 0) return;
}

static int is_file(int file) {
    struct stat status;
    return file > 2 && fstat(file, &status) == 0 && (S_ISREG(status.st_mode) || S_ISDIR(status.st_mode));
}

/* Whether this call fails; 2 if half of it is done before the end. */
static int fault(int takes_space) {
    long call = atomic_fetch_add(&calls, 1) + 1;
    if (at == 0 || call < at) return 0;
    if (call > at) {
        if (strcmp(kind, "full") || !takes_space) return 0;
    } else if (!strcmp(kind, "torn") && takes_space) {
        return 2;
    } else if (!strcmp(kind, "kill") || !strcmp(kind, "torn")) {
        kill(getpid(), SIGKILL);
    } else if (!strcmp(kind, "full") && !takes_space) {
        return 0;
    }
    errno = takes_space ? ENOSPC : EIO;
    return 1;
}

#define NEXT(name) __typeof__(&name) next = (__typeof__(&name))dlsym(RTLD_NEXT, #name)

#define WRITES(result, name, declared, file, half, ...)                      \
    result name declared {                                                   \
        NEXT(name);                                                          \
        int what = is_file(file) ? fault(1) : 0;                             \
        if (what == 1) return -1;                                            \
        if (what == 2) {                                                     \
            half;                                                            \
            kill(getpid(), SIGKILL);                                         \
        }                                                                    \
        return next(__VA_ARGS__);                                            \
    }

#define NAMES(name, declared, takes_space, ...)                              \
    int name declared {                                                      \
        NEXT(name);                                                          \
        int what = fault(takes_space);                                       \
        if (what == 2) kill(getpid(), SIGKILL);                              \
        return what ? -1 : next(__VA_ARGS__);                                \
    }

WRITES(ssize_t, write, (int file, const void *bytes, size_t count), file, next(file, bytes, count / 2), file, bytes, count)
WRITES(ssize_t, writev, (int file, const struct iovec *parts, int count), file, next(file, parts, count / 2), file, parts, count)
WRITES(ssize_t, pwrite64, (int file, const void *bytes, size_t count, off64_t place), file, next(file, bytes, count / 2, place), file, bytes, count, place)

int fsync(int file) {
    NEXT(fsync);
    return is_file(file) && fault(0) ? -1 : next(file);
}

int fdatasync(int file) {
    NEXT(fdatasync);
    return is_file(file) && fault(0) ? -1 : next(file);
}

NAMES(rename, (const char *from, const char *to), 0, from, to)
NAMES(renameat2, (int a, const char *from, int b, const char *to, unsigned flags), 0, a, from, b, to, flags)
NAMES(link, (const char *from, const char *to), 1, from, to)
NAMES(linkat, (int a, const char *from, int b, const char *to, int flags), 1, a, from, b, to, flags)
NAMES(unlink, (const char *path), 0, path)
NAMES(unlinkat, (int folder, const char *path, int flags), 0, folder, path, flags)
NAMES(rmdir, (const char *path), 0, path)
NAMES(mkdir, (const char *path, mode_t mode), 1, path, mode)
NAMES(ftruncate64, (int file, off64_t length), 0, file, length)

int open64(const char *path, int flags, ...) {
    NEXT(open64);
    va_list rest;
    va_start(rest, flags);
    mode_t mode = flags & O_CREAT ? va_arg(rest, mode_t) : 0;
    va_end(rest);
    if (flags & O_CREAT) {
        int what = fault(1);
        if (what == 2) kill(getpid(), SIGKILL);
        if (what) return -1;
    }
    return next(path, flags, mode);
}
