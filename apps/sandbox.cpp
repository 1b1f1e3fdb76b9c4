// SPDX-License-Identifier: Apache-2.0
#include "sandbox.h"

#include <cerrno>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <system_error>

#ifdef COVIS_SANDBOX
#include <fcntl.h>
#include <linux/landlock.h>
#include <seccomp.h>
#include <sys/prctl.h>
#include <sys/syscall.h>
#include <unistd.h>
#endif

namespace covis::app {

#ifdef COVIS_SANDBOX
namespace {

tl::unexpected<Error> problem(const std::string& what, int error) {
  return fail("--sandbox: " + what + ": " + std::generic_category().message(error));
}

// Files: Landlock (https://docs.kernel.org/userspace-api/landlock.html), which has no functions in the C library.

constexpr uint64_t kTruncate = uint64_t{1} << 14;  // LANDLOCK_ACCESS_FS_TRUNCATE, younger than some headers
constexpr uint64_t kInsideFolders = LANDLOCK_ACCESS_FS_WRITE_FILE | LANDLOCK_ACCESS_FS_MAKE_REG |
                                    LANDLOCK_ACCESS_FS_MAKE_DIR | LANDLOCK_ACCESS_FS_REMOVE_FILE |
                                    LANDLOCK_ACCESS_FS_REMOVE_DIR;
constexpr uint64_t kNowhere = LANDLOCK_ACCESS_FS_EXECUTE | LANDLOCK_ACCESS_FS_MAKE_CHAR |
                              LANDLOCK_ACCESS_FS_MAKE_BLOCK | LANDLOCK_ACCESS_FS_MAKE_SOCK |
                              LANDLOCK_ACCESS_FS_MAKE_FIFO | LANDLOCK_ACCESS_FS_MAKE_SYM;

// The rights of younger versions that the kernel can take away.
uint64_t younger_rights(long version) {
  return (version >= 2 ? uint64_t{LANDLOCK_ACCESS_FS_REFER} : 0) | (version >= 3 ? kTruncate : 0);
}

Result<void> allow_beneath(int rules, const std::string& folder, uint64_t rights) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error) return problem(folder + ": the folder can't be made", error.value());
  landlock_path_beneath_attr beneath{};
  beneath.allowed_access = rights;
  beneath.parent_fd = ::open(folder.c_str(), O_PATH | O_DIRECTORY | O_CLOEXEC);
  if (beneath.parent_fd < 0) return problem(folder, errno);
  const long added = ::syscall(SYS_landlock_add_rule, rules, LANDLOCK_RULE_PATH_BENEATH, &beneath, 0);
  const int reason = errno;
  ::close(beneath.parent_fd);
  return added == 0 ? Result<void>() : problem(folder, reason);
}

Result<void> restrict_files(const std::vector<std::string>& writable) {
  const long version = ::syscall(SYS_landlock_create_ruleset, nullptr, 0, LANDLOCK_CREATE_RULESET_VERSION);
  if (version < 1) return problem("this system has no Landlock (Linux 5.13 or later, enabled)", errno);
  const uint64_t inside = kInsideFolders | younger_rights(version);
  landlock_ruleset_attr handled{};
  handled.handled_access_fs = inside | kNowhere;
  const auto rules = static_cast<int>(::syscall(SYS_landlock_create_ruleset, &handled, sizeof(handled), 0));
  if (rules < 0) return problem("Landlock", errno);
  Result<void> done;
  for (const std::string& folder : writable) {
    if (done) done = allow_beneath(rules, folder, inside);
  }
  if (done && ::syscall(SYS_landlock_restrict_self, rules, 0) != 0) done = problem("Landlock", errno);
  ::close(rules);
  return done;
}

// Everything else: calls of the system that Covis has no use for, and whoever took it over would.
Result<void> restrict_calls() {
  const scmp_filter_ctx filter = seccomp_init(SCMP_ACT_ALLOW);
  if (!filter) return problem("seccomp", ENOMEM);
  int error = 0;
  const auto refuse = [&](int call) {
    if (error == 0) error = -seccomp_rule_add(filter, SCMP_ACT_ERRNO(EPERM), call, 0);
  };
  for (const int call : {SCMP_SYS(execve), SCMP_SYS(execveat)}) refuse(call);
  for (const int call : {SCMP_SYS(socket), SCMP_SYS(socketpair), SCMP_SYS(connect), SCMP_SYS(bind), SCMP_SYS(listen)})
    refuse(call);
  for (const int call : {SCMP_SYS(ptrace), SCMP_SYS(process_vm_readv), SCMP_SYS(process_vm_writev),
                         SCMP_SYS(pidfd_getfd), SCMP_SYS(pidfd_send_signal), SCMP_SYS(kcmp)})
    refuse(call);
  for (const int call : {SCMP_SYS(mount), SCMP_SYS(umount2), SCMP_SYS(pivot_root), SCMP_SYS(chroot), SCMP_SYS(unshare),
                         SCMP_SYS(setns), SCMP_SYS(open_by_handle_at), SCMP_SYS(fsopen), SCMP_SYS(move_mount)})
    refuse(call);
  for (const int call : {SCMP_SYS(bpf), SCMP_SYS(userfaultfd), SCMP_SYS(perf_event_open), SCMP_SYS(io_uring_setup),
                         SCMP_SYS(keyctl), SCMP_SYS(add_key), SCMP_SYS(request_key), SCMP_SYS(init_module),
                         SCMP_SYS(finit_module), SCMP_SYS(delete_module), SCMP_SYS(kexec_load)})
    refuse(call);
  // Signal 0 only asks whether a process lives.
  if (error == 0) error = -seccomp_rule_add(filter, SCMP_ACT_ERRNO(EPERM), SCMP_SYS(kill), 1, SCMP_A1(SCMP_CMP_NE, 0));
  if (error == 0) error = -seccomp_load(filter);
  seccomp_release(filter);
  return error == 0 ? Result<void>() : problem("seccomp", error);
}

}  // namespace

Result<void> enter_sandbox(const std::vector<std::string>& writable) {
  // Rights that a set-user-id program would give are given up first: the kernel asks for it.
  if (::prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) != 0) return problem("no new privileges", errno);
  if (auto done = restrict_files(writable); !done) return done;
  if (!writable.empty()) ::setenv("TMPDIR", std::filesystem::absolute(writable.front()).c_str(), 1);
  return restrict_calls();
}

#else

Result<void> enter_sandbox(const std::vector<std::string>& /*writable*/) {
  return fail("--sandbox: Covis was built without libseccomp");
}

#endif

}  // namespace covis::app
