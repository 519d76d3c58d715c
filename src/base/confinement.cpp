#include "base/confinement.hpp"

#include <cerrno>
#include <cstddef>
#include <fcntl.h>
#include <linux/audit.h>
#include <linux/filter.h>
#include <linux/seccomp.h>
#include <sys/prctl.h>
#include <sys/syscall.h>
#include <vector>

namespace pliant {
namespace {

#if defined(__x86_64__)
constexpr unsigned native = AUDIT_ARCH_X86_64;
#elif defined(__aarch64__)
constexpr unsigned native = AUDIT_ARCH_AARCH64;
#else
constexpr unsigned native = 0;
#endif

/// Calls that run a program, change the file system or reach other machines, whatever their arguments.
constexpr unsigned refused[] = {
#ifdef SYS_creat
    SYS_creat,
    SYS_rename,
    SYS_unlink,
    SYS_rmdir,
    SYS_mkdir,
    SYS_link,
    SYS_symlink,
    SYS_mknod,
    SYS_chmod,
    SYS_chown,
    SYS_lchown,
#endif
    SYS_execve,
    SYS_execveat,
    SYS_renameat,
    SYS_renameat2,
    SYS_unlinkat,
    SYS_mkdirat,
    SYS_linkat,
    SYS_symlinkat,
    SYS_mknodat,
    SYS_fchmodat,
    SYS_fchownat,
    SYS_truncate,
    SYS_setxattr,
    SYS_lsetxattr,
    SYS_socket,
    SYS_ptrace,
    SYS_open_by_handle_at,
    SYS_process_vm_writev,
#ifdef SYS_openat2
    SYS_openat2,
#endif
#ifdef SYS_io_uring_setup
    SYS_io_uring_setup,
#endif
};

constexpr unsigned writing = O_WRONLY | O_RDWR | O_CREAT | O_TRUNC;
constexpr unsigned deny = SECCOMP_RET_ERRNO | EACCES;

sock_filter load(std::size_t offset) {
  return BPF_STMT(BPF_LD | BPF_W | BPF_ABS, static_cast<unsigned>(offset));
}

/// Skips the next `count` statements unless the loaded value is `value`.
sock_filter unless_equal_skip(unsigned value, unsigned char count) {
  return BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, value, 0, count);
}

sock_filter answer(unsigned value) {
  return BPF_STMT(BPF_RET | BPF_K, value);
}

/// The lower half of the argument (both supported machines are little-endian).
constexpr std::size_t argument(std::size_t i) {
  return offsetof(seccomp_data, args) + i * sizeof(__u64);
}

void refuse_to_open_for_writing(std::vector<sock_filter>& program, unsigned call, std::size_t flags) {
  program.push_back(unless_equal_skip(call, 4));
  program.push_back(load(argument(flags)));
  program.push_back(BPF_JUMP(BPF_JMP | BPF_JSET | BPF_K, writing, 0, 1));
  program.push_back(answer(deny));
  program.push_back(answer(SECCOMP_RET_ALLOW));
}

std::vector<sock_filter> filter() {
  std::vector<sock_filter> program{load(offsetof(seccomp_data, arch)),
                                   BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, native, 1, 0), answer(deny),
                                   load(offsetof(seccomp_data, nr))};
#ifdef __x86_64__
  constexpr unsigned x32 = 0x40000000;  // the same calls under other numbers
  program.push_back(BPF_JUMP(BPF_JMP | BPF_JSET | BPF_K, x32, 0, 1));
  program.push_back(answer(deny));
#endif
  for (const unsigned call : refused) {
    program.push_back(unless_equal_skip(call, 1));
    program.push_back(answer(deny));
  }
#ifdef SYS_open
  refuse_to_open_for_writing(program, SYS_open, 1);
#endif
  refuse_to_open_for_writing(program, SYS_openat, 2);
  program.push_back(answer(SECCOMP_RET_ALLOW));
  return program;
}

}  // namespace

bool renounce_commands_and_files() noexcept {
  if (native == 0) return false;
  try {
    std::vector<sock_filter> statements = filter();
    const sock_fprog program{static_cast<unsigned short>(statements.size()), statements.data()};
    return prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) == 0 && prctl(PR_SET_SECCOMP, SECCOMP_MODE_FILTER, &program) == 0;
  } catch (...) {
    return false;
  }
}

}  // namespace pliant
