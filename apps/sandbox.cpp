// SPDX-License-Identifier: Apache-2.0
#include "sandbox.h"

#include <cerrno>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <initializer_list>
#include <iterator>
#include <system_error>

#ifdef COVIS_SANDBOX
#include <fcntl.h>
#include <linux/landlock.h>
#include <sched.h>
#include <seccomp.h>
#include <sys/ioctl.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <unistd.h>
#endif

namespace covis::app {

#ifdef COVIS_SANDBOX
namespace {

tl::unexpected<Error> problem(const std::string& what, int error) {
  return fail("--sandbox: " + what + ": " + std::generic_category().message(error));
}

// Landlock keeps files (https://docs.kernel.org/userspace-api/landlock.html). It has no functions in the C library, and
// two of its rights, LANDLOCK_ACCESS_FS_REFER and LANDLOCK_ACCESS_FS_TRUNCATE, are younger than some headers.
constexpr uint64_t kRefer = uint64_t{1} << 13, kTruncate = uint64_t{1} << 14;
constexpr int kFchmodat2 = 452;  // number of a system call that is younger than some headers, too
constexpr uint64_t kInsideFolders = LANDLOCK_ACCESS_FS_WRITE_FILE | LANDLOCK_ACCESS_FS_MAKE_REG |
                                    LANDLOCK_ACCESS_FS_MAKE_DIR | LANDLOCK_ACCESS_FS_REMOVE_FILE |
                                    LANDLOCK_ACCESS_FS_REMOVE_DIR;
constexpr uint64_t kNowhere = LANDLOCK_ACCESS_FS_EXECUTE | LANDLOCK_ACCESS_FS_MAKE_CHAR |
                              LANDLOCK_ACCESS_FS_MAKE_BLOCK | LANDLOCK_ACCESS_FS_MAKE_SOCK |
                              LANDLOCK_ACCESS_FS_MAKE_FIFO | LANDLOCK_ACCESS_FS_MAKE_SYM;

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
  const uint64_t inside = kInsideFolders | (version >= 2 ? kRefer : 0) | (version >= 3 ? kTruncate : 0);
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

// A filter of the calls of the system that Covis has no use for, and whoever took it over would have.
class CallFilter {
 public:
  CallFilter() : filter_(seccomp_init(SCMP_ACT_ALLOW)) {
    if (!filter_) error_ = ENOMEM;
    add(seccomp_attr_set(filter_, SCMP_FLTATR_CTL_TSYNC, 1));
  }
  ~CallFilter() { seccomp_release(filter_); }

  void refuse(std::initializer_list<int> calls) {
    for (const int call : calls) add(seccomp_rule_add(filter_, SCMP_ACT_ERRNO(EPERM), call, 0));
  }
  // The answer is that of a kernel without these calls: the C library makes do with older ones, whose arguments can be
  // looked into.
  void deny_existence(std::initializer_list<int> calls) {
    for (const int call : calls) add(seccomp_rule_add(filter_, SCMP_ACT_ERRNO(ENOSYS), call, 0));
  }
  void refuse_if(int call, const scmp_arg_cmp& argument) {
    add(seccomp_rule_add(filter_, SCMP_ACT_ERRNO(EPERM), call, 1, argument));
  }
  int load() { return add(seccomp_load(filter_)), error_; }

 private:
  void add(int result) {
    if (error_ == 0) error_ = -result;
  }

  const scmp_filter_ctx filter_;
  int error_ = 0;  // errno of the first problem
};

// Refuses programs, connections and shared memory.
void refuse_others(CallFilter& filter) {
  filter.refuse({SCMP_SYS(execve), SCMP_SYS(execveat), SCMP_SYS(socket), SCMP_SYS(socketpair), SCMP_SYS(connect),
                 SCMP_SYS(bind), SCMP_SYS(listen)});
  filter.refuse({SCMP_SYS(shmget), SCMP_SYS(shmat), SCMP_SYS(shmctl), SCMP_SYS(semget), SCMP_SYS(msgget),
                 SCMP_SYS(mq_open), SCMP_SYS(mq_unlink)});
  // Two requests type text into a terminal, for the shell that reads it next.
  for (const unsigned request : {TIOCSTI, TIOCLINUX})
    filter.refuse_if(SCMP_SYS(ioctl), SCMP_A1(SCMP_CMP_MASKED_EQ, 0xffffffffu, request));
}

// Refuses what reaches other processes. Signal 0 only asks if one lives.
void refuse_processes(CallFilter& filter) {
  filter.refuse({SCMP_SYS(ptrace), SCMP_SYS(process_vm_readv), SCMP_SYS(process_vm_writev), SCMP_SYS(pidfd_getfd),
                 SCMP_SYS(pidfd_send_signal), SCMP_SYS(tkill), SCMP_SYS(rt_sigqueueinfo), SCMP_SYS(rt_tgsigqueueinfo),
                 SCMP_SYS(ioprio_set)});
  filter.refuse_if(SCMP_SYS(kill), SCMP_A1(SCMP_CMP_NE, 0));
  filter.refuse_if(SCMP_SYS(tgkill), SCMP_A0(SCMP_CMP_NE, static_cast<scmp_datum_t>(::getpid())));
  for (const scmp_datum_t command : {F_SETOWN, F_SETOWN_EX})
    filter.refuse_if(SCMP_SYS(fcntl), SCMP_A1(SCMP_CMP_EQ, command));
  // Their weights and limits: of this process alone, which is 0 (and the first kind of setpriority()).
  for (const int call : {SCMP_SYS(prlimit64), SCMP_SYS(sched_setaffinity), SCMP_SYS(sched_setscheduler),
                         SCMP_SYS(sched_setparam), SCMP_SYS(sched_setattr)})
    filter.refuse_if(call, SCMP_A0(SCMP_CMP_NE, 0));
  filter.refuse_if(SCMP_SYS(setpriority), SCMP_A0(SCMP_CMP_NE, PRIO_PROCESS));
  filter.refuse_if(SCMP_SYS(setpriority), SCMP_A1(SCMP_CMP_NE, 0));
}

// Landlock does not know of owners, permissions and times of files, and its first versions not of emptying them.
void refuse_attributes(CallFilter& filter) {
  filter.refuse({SCMP_SYS(chmod), SCMP_SYS(fchmod), SCMP_SYS(fchmodat), SCMP_SYS(chown), SCMP_SYS(lchown),
                 SCMP_SYS(fchown), SCMP_SYS(fchownat), SCMP_SYS(utime), SCMP_SYS(utimes), SCMP_SYS(futimesat),
                 SCMP_SYS(utimensat)});
  filter.deny_existence({SCMP_SYS(openat2), kFchmodat2});
  filter.refuse({SCMP_SYS(setxattr), SCMP_SYS(lsetxattr), SCMP_SYS(fsetxattr), SCMP_SYS(removexattr),
                 SCMP_SYS(lremovexattr), SCMP_SYS(fremovexattr), SCMP_SYS(truncate)});
  constexpr scmp_datum_t kMode = O_ACCMODE | O_TRUNC;
  filter.refuse_if(SCMP_SYS(open), SCMP_A1(SCMP_CMP_MASKED_EQ, kMode, O_RDONLY | O_TRUNC));
  filter.refuse_if(SCMP_SYS(openat), SCMP_A2(SCMP_CMP_MASKED_EQ, kMode, O_RDONLY | O_TRUNC));
}

// Refuses what changes the system, and namespaces in which other rules would hold.
void refuse_system(CallFilter& filter) {
  filter.refuse({SCMP_SYS(mount), SCMP_SYS(umount2), SCMP_SYS(pivot_root), SCMP_SYS(chroot), SCMP_SYS(unshare),
                 SCMP_SYS(setns), SCMP_SYS(open_by_handle_at), SCMP_SYS(fsopen), SCMP_SYS(move_mount)});
  filter.refuse({SCMP_SYS(bpf), SCMP_SYS(userfaultfd), SCMP_SYS(perf_event_open), SCMP_SYS(io_uring_setup),
                 SCMP_SYS(keyctl), SCMP_SYS(add_key), SCMP_SYS(request_key), SCMP_SYS(init_module),
                 SCMP_SYS(finit_module), SCMP_SYS(delete_module), SCMP_SYS(kexec_load), SCMP_SYS(reboot)});
  for (const unsigned kind :
       {CLONE_NEWUSER, CLONE_NEWNS, CLONE_NEWPID, CLONE_NEWNET, CLONE_NEWIPC, CLONE_NEWUTS, CLONE_NEWCGROUP})
    filter.refuse_if(SCMP_SYS(clone), SCMP_A0(SCMP_CMP_MASKED_EQ, kind, kind));
  filter.deny_existence({SCMP_SYS(clone3)});
}

Result<void> restrict_calls() {
  CallFilter filter;
  refuse_others(filter);
  refuse_processes(filter);
  refuse_attributes(filter);
  refuse_system(filter);
  const int error = filter.load();
  return error == 0 ? Result<void>() : problem("seccomp", error);
}

// Landlock restricts the thread that asks for it alone.
Result<void> check_alone() {
  std::error_code error;
  const std::filesystem::directory_iterator tasks("/proc/self/task", error);
  if (!error && std::distance(begin(tasks), end(tasks)) == 1) return {};
  return fail("--sandbox: a library has started threads as it was loaded (of OpenBLAS: set OPENBLAS_NUM_THREADS=1)");
}

}  // namespace

Result<void> enter_sandbox(const std::vector<std::string>& writable) {
  if (auto alone = check_alone(); !alone) return alone;
  // Rights that a set-user-id program would give are given up first: the kernel asks for it.
  if (::prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) != 0) return problem("no new privileges", errno);
  if (auto done = restrict_files(writable); !done) return done;
  if (!writable.empty()) ::setenv("TMPDIR", std::filesystem::absolute(writable.front()).c_str(), 1);
  return restrict_calls();
}

#else

Result<void> enter_sandbox(const std::vector<std::string>& /*writable*/) {
  return fail("--sandbox: Covis was built without libseccomp or without the headers of Landlock");
}

#endif

}  // namespace covis::app
