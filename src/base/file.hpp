/// Files through the operating system. Every failure is a FileError that names the file and says why; nothing here is
/// collective.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string_view>

namespace pliant {

/// create: empties an existing file. anew: makes a file and follows no link; what has its name, which can only be what
/// an earlier run left, is removed. modify: the file must exist. append: writes go to the end, the file is made if
/// missing.
enum class FileMode { create, anew, modify, append };

/// An open file; closed at the end of the scope. `close()` closes earlier and tells failures, which some file systems
/// report only then.
class File {
 public:
  File(std::filesystem::path path, FileMode mode);
  File(File&& other) noexcept;
  File& operator=(File&& other) noexcept;
  File(const File&) = delete;
  File& operator=(const File&) = delete;
  ~File();

  /// Writes all of `text` at the current position.
  void write(std::string_view text);

  /// Writes all of `text` at the end of a file that still has its name, or nothing: what a full disk has cut off goes
  /// again.
  void append_whole(std::string_view text);

  /// Writes all bytes at `offset` [bytes], however many there are.
  void write_at(std::int64_t offset, std::span<const std::byte> bytes);

  /// Makes sure that `num_bytes` from `offset` on can be written: takes them from the disk now, or fails with the file
  /// as long as before. It gets no shorter.
  void reserve(std::int64_t offset, std::int64_t num_bytes);

  /// Cuts the file (or extends it with zeros) to `num_bytes`.
  void resize(std::int64_t num_bytes);

  /// Size [bytes].
  std::int64_t size() const;

  /// Returns when the data have reached the disk.
  void sync();
  void close();

 private:
  [[noreturn]] void fail(int error) const;

  std::filesystem::path path_;
  int descriptor_ = -1;
};

/// What is written survives: the end of this process at any moment; or a loss of power too, for which it is brought to
/// the disk, and that takes milliseconds.
enum class Durability { process, power };

/// Replaces `file` by `text` so that a reader, or a run killed at any moment, sees either the old text or the new one:
/// written under the name `<file>.part`, renamed. A device or a pipe is written to as it is.
void write_text_atomically(const std::filesystem::path& file, std::string_view text,
                           Durability durability = Durability::power);

/// Gives a file the name of another, which it replaces. FileError if that is a device or a pipe.
void replace_file(const std::filesystem::path& from, const std::filesystem::path& to,
                  Durability durability = Durability::power);

/// Makes the directory and those above it; an existing one is fine.
void make_directory(const std::filesystem::path& directory);

/// While it lives, no other process has the same on that directory, as far as its file system tells processes of one
/// another. It ends with the process, however that ends.
class DirectoryLock {
 public:
  /// Waits this long for another one to end, then throws FileError. Nothing is locked where locks are not known.
  DirectoryLock(const std::filesystem::path& directory, std::chrono::milliseconds patience);
  DirectoryLock(const DirectoryLock&) = delete;
  DirectoryLock& operator=(const DirectoryLock&) = delete;
  ~DirectoryLock();

 private:
  int descriptor_ = -1;
};

}  // namespace pliant
