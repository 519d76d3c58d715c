#include "base/file.hpp"

#include "base/error.hpp"
#include "base/text.hpp"

#include <algorithm>
#include <cerrno>
#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <system_error>
#include <thread>
#include <unistd.h>
#include <utility>
#include <vector>

namespace pliant {
namespace {

// Linux writes at most 2^31 - 4096 bytes at once.
constexpr std::size_t largest_write = std::size_t{1} << 30;

int flags_of(FileMode mode) {
  switch (mode) {
    case FileMode::create:
      return O_WRONLY | O_CREAT | O_TRUNC;
    case FileMode::anew:
      return O_WRONLY | O_CREAT | O_EXCL | O_NOFOLLOW;
    case FileMode::modify:
      return O_WRONLY;
    case FileMode::append:
      break;
  }
  return O_WRONLY | O_CREAT | O_APPEND;
}

FileError failure(const std::filesystem::path& path, int error) {
  return FileError("cannot write '" + path.string() + "': " + std::generic_category().message(error));
}

/// A device or a pipe, such as /dev/null: written to, never replaced.
bool is_special(const std::filesystem::path& path) {
  std::error_code ignored;
  return std::filesystem::is_other(path, ignored);
}

}  // namespace

File::File(std::filesystem::path path, FileMode mode) : path_(std::move(path)) {
  // In a directory that others can write to, somebody could put a link or a file of their own under this name. A link
  // is removed, not its target; a file of another user that cannot be removed is an error, so that they cannot read
  // what we write.
  if (mode == FileMode::anew) (void)::unlink(path_.c_str());
  do {
    descriptor_ = ::open(path_.c_str(), flags_of(mode) | O_CLOEXEC, 0666);
  } while (descriptor_ < 0 && errno == EINTR);
  if (descriptor_ < 0) fail(errno);
}

File::File(File&& other) noexcept : path_(std::move(other.path_)), descriptor_(std::exchange(other.descriptor_, -1)) {}

File& File::operator=(File&& other) noexcept {
  std::swap(path_, other.path_);
  std::swap(descriptor_, other.descriptor_);
  return *this;
}

File::~File() {
  if (descriptor_ >= 0) (void)::close(descriptor_);
}

void File::fail(int error) const {
  throw failure(path_, error);
}

void File::write(std::string_view text) {
  while (!text.empty()) {
    const ssize_t written = ::write(descriptor_, text.data(), std::min(text.size(), largest_write));
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) fail(errno);
    text.remove_prefix(static_cast<std::size_t>(written));
  }
}

void File::append_whole(std::string_view text) {
  struct stat mine {
  }, named{};
  if (::fstat(descriptor_, &mine) != 0) fail(errno);
  if (::stat(path_.c_str(), &named) != 0) fail(errno);
  if (mine.st_dev != named.st_dev || mine.st_ino != named.st_ino) {
    throw FileError("cannot write '" + path_.string() + "': another file has taken its place");
  }
  try {
    write(text);
  } catch (const FileError&) {
    // Only the first failure is reported.
    const bool is_cut = ::ftruncate(descriptor_, mine.st_size) == 0;
    if (is_cut) (void)::lseek(descriptor_, mine.st_size, SEEK_SET);
    throw;
  }
}

void File::write_at(std::int64_t offset, std::span<const std::byte> bytes) {
  while (!bytes.empty()) {
    const ssize_t written = ::pwrite(descriptor_, bytes.data(), std::min(bytes.size(), largest_write), offset);
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) fail(errno);
    offset += written;
    bytes = bytes.subspan(static_cast<std::size_t>(written));
  }
}

void File::reserve(std::int64_t offset, std::int64_t num_bytes) {
  const std::int64_t old_size = size();
  int error = 0;
  do {
    error = ::posix_fallocate(descriptor_, offset, num_bytes);
  } while (error == EINTR);
  // A file system that cannot reserve space does not stop the run: the writes themselves are checked.
  if (error == 0 || error == EOPNOTSUPP || error == EINVAL) return;
  resize(old_size);
  fail(error);
}

void File::resize(std::int64_t num_bytes) {
  if (::ftruncate(descriptor_, num_bytes) != 0) fail(errno);
}

std::int64_t File::size() const {
  struct stat status {};
  if (::fstat(descriptor_, &status) != 0) fail(errno);
  return status.st_size;
}

void File::sync() {
  // EINVAL: the file is on something that does not support sync, such as a pipe.
  if (::fdatasync(descriptor_) != 0 && errno != EINVAL) fail(errno);
}

void File::close() {
  const int descriptor = std::exchange(descriptor_, -1);
  if (descriptor >= 0 && ::close(descriptor) != 0 && errno != EINTR) fail(errno);
}

void write_text_atomically(const std::filesystem::path& file, std::string_view text, Durability durability) {
  if (is_special(file)) {
    File out(file, FileMode::create);
    out.write(text);
    return out.close();
  }
  std::filesystem::path part = file;
  part += ".part";
  try {
    File out(part, FileMode::anew);
    out.write(text);
    if (durability == Durability::power) out.sync();
    out.close();
  } catch (const FileError&) {
    std::error_code ignored;
    std::filesystem::remove(part, ignored);
    throw;
  }
  replace_file(part, file, durability);
}

void replace_file(const std::filesystem::path& from, const std::filesystem::path& to, Durability durability) {
  if (is_special(to)) throw FileError("cannot write '" + to.string() + "': it is there and is not a regular file");
  std::error_code error;
  std::filesystem::rename(from, to, error);
  if (error) throw failure(to, error.value());
  if (durability == Durability::process) return;
  // The new name is on disk once its directory is. Continue if the directory cannot be read or does not support sync.
  const std::filesystem::path directory = to.has_parent_path() ? to.parent_path() : ".";
  const int descriptor = ::open(directory.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (descriptor < 0) return;
  (void)::fsync(descriptor);
  (void)::close(descriptor);
}

void make_directory(const std::filesystem::path& directory) {
  std::error_code error;
  std::filesystem::create_directories(directory, error);
  const bool is_forbidden = error == std::errc::permission_denied;
  if (error) {
    throw FileError("cannot make the directory '" + directory.string() + "': " + error.message() +
                    (is_forbidden ? "; `--output` names another" : ""));
  }
}

std::string similar_file(const std::filesystem::path& missing) {
  constexpr std::size_t most = 10000;  // entries
  std::error_code error;
  std::vector<std::string> names;
  const std::filesystem::path directory = missing.has_parent_path() ? missing.parent_path() : ".";
  for (std::filesystem::directory_iterator entry(directory, error), end; !error && entry != end && names.size() < most;
       entry.increment(error)) {
    std::error_code ignored;
    if (entry->is_regular_file(ignored)) names.push_back(entry->path().filename().string());
  }
  std::ranges::sort(names);
  return did_you_mean(missing.filename().string(), names);
}

DirectoryLock::DirectoryLock(const std::filesystem::path& directory, std::chrono::milliseconds patience)
    : descriptor_(::open(directory.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC)) {
  using Clock = std::chrono::steady_clock;
  const auto last = Clock::now() + patience;
  while (descriptor_ >= 0 && ::flock(descriptor_, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK) {
    if (Clock::now() > last) {
      ::close(descriptor_);
      throw FileError("another run is writing into '" + directory.string() +
                      "'; wait for its end, or give this one another directory");
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
  }
}

DirectoryLock::~DirectoryLock() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

}  // namespace pliant
