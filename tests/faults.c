/* Faults of a file system, for tests: a library to preload, which counts the calls that change
 * files in one folder and lets one of them fail, or kills the process there.
 *
 * fault_arm(folder, number, kind): kind 0 counts only, -1 kills before the call, -2 kills in the
 * midst of it (a write is done by half), any other is the errno of that call and all later ones.
 */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <signal.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>
#include <sys/types.h>
#include <unistd.h>

static char folder[PATH_MAX];
static volatile long at, count;
static volatile int kind, armed;

void fault_arm(const char *where, long number, int what) {
    snprintf(folder, sizeof folder, "%s", where);
    at = number; kind = what; count = 0; armed = 1;
}
long fault_count(void) { return count; }

static int inside(const char *path) {
    return path && strncmp(path, folder, strlen(folder)) == 0;
}
static int inside_fd(int fd) {
    char link[64], path[PATH_MAX];
    snprintf(link, sizeof link, "/proc/self/fd/%d", fd);
    ssize_t n = readlink(link, path, sizeof path - 1);
    if (n < 0) return 0;
    path[n] = 0;
    return inside(path);
}
/* 0: go on; 1: fail with errno; 2: do half of it, then die. */
static int fault(int counts) {
    if (!armed || !counts) return 0;
    ++count;
    if (kind == 0 || count < at) return 0;
    if (kind == -1) kill(getpid(), SIGKILL);
    if (kind == -2) return 2;
    errno = kind;
    return 1;
}
#define REAL(name) static __typeof__(&name) real; if (!real) real = dlsym(RTLD_NEXT, #name)
#define DIE kill(getpid(), SIGKILL)

ssize_t write(int fd, const void *b, size_t n) {
    REAL(write);
    int f = fault(armed && inside_fd(fd));
    if (f == 1) return -1;
    if (f == 2) { real(fd, b, n / 2); DIE; }
    return real(fd, b, n);
}
ssize_t pwrite(int fd, const void *b, size_t n, off_t o) {
    REAL(pwrite);
    int f = fault(armed && inside_fd(fd));
    if (f == 1) return -1;
    if (f == 2) { real(fd, b, n / 2, o); DIE; }
    return real(fd, b, n, o);
}
ssize_t pwrite64(int fd, const void *b, size_t n, off64_t o) {
    REAL(pwrite64);
    int f = fault(armed && inside_fd(fd));
    if (f == 1) return -1;
    if (f == 2) { real(fd, b, n / 2, o); DIE; }
    return real(fd, b, n, o);
}
int fsync(int fd) {
    REAL(fsync);
    int f = fault(armed && inside_fd(fd));
    if (f == 1) return -1;
    int r = real(fd);
    if (f == 2) DIE;
    return r;
}
int ftruncate(int fd, off_t n) {
    REAL(ftruncate);
    int f = fault(armed && inside_fd(fd));
    if (f == 1) return -1;
    int r = real(fd, n);
    if (f == 2) DIE;
    return r;
}
int ftruncate64(int fd, off64_t n) {
    REAL(ftruncate64);
    int f = fault(armed && inside_fd(fd));
    if (f == 1) return -1;
    int r = real(fd, n);
    if (f == 2) DIE;
    return r;
}
int rename(const char *a, const char *b) {
    REAL(rename);
    int f = fault(armed && inside(a));
    if (f == 1 && kind != ENOSPC) return -1; /* a full disk lets files have other names */
    int r = real(a, b);
    if (f == 2) DIE;
    return r;
}
int unlink(const char *a) {
    REAL(unlink);
    int f = fault(armed && inside(a));
    if (f == 1 && kind != ENOSPC) return -1; /* and go */
    int r = real(a);
    if (f == 2) DIE;
    return r;
}
int mkdir(const char *a, mode_t m) {
    REAL(mkdir);
    int f = fault(armed && inside(a));
    if (f == 1) return -1;
    int r = real(a, m);
    if (f == 2) DIE;
    return r;
}
static int opened(const char *path, int flags, mode_t mode) {
    static int (*real)(const char *, int, ...);
    if (!real) real = dlsym(RTLD_NEXT, "open64");
    int f = fault(armed && (flags & (O_CREAT | O_TRUNC)) && inside(path));
    if (f == 1) return -1;
    int r = real(path, flags, mode);
    if (f == 2) DIE;
    return r;
}
static mode_t mode_of(int flags, va_list a) { return flags & O_CREAT ? va_arg(a, mode_t) : 0; }
int open(const char *p, int flags, ...) {
    va_list a; va_start(a, flags); mode_t m = mode_of(flags, a); va_end(a);
    return opened(p, flags, m);
}
int open64(const char *p, int flags, ...) {
    va_list a; va_start(a, flags); mode_t m = mode_of(flags, a); va_end(a);
    return opened(p, flags, m);
}
static FILE *opened_stream(const char *path, const char *how) {
    static FILE *(*real)(const char *, const char *);
    if (!real) real = dlsym(RTLD_NEXT, "fopen64");
    int f = fault(armed && strpbrk(how, "wa+") && inside(path));
    if (f == 1) return NULL;
    FILE *r = real(path, how);
    if (f == 2) DIE;
    return r;
}
FILE *fopen(const char *p, const char *how) { return opened_stream(p, how); }
FILE *fopen64(const char *p, const char *how) { return opened_stream(p, how); }
