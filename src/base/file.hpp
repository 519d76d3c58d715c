/// Files through the operating system. Every failure is a FileError that names the file and the reason; nothing here is
/// collective.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>

namespace pliant {

/// create: truncates an existing file. anew: creates the file and follows no link; an existing file of this name, which
/// can only be left from an earlier run, is removed. modify: the file must exist. append: writes go to the end; a
/// missing file is created.
enum class FileMode { create, anew, modify, append };

/// An open file, closed at the end of the scope. `close()` closes it earlier and reports failures, which some file
/// systems report only then.
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

  /// Appends all of `text`, if the file still exists under its name, or nothing: what a full disk cut off is removed
  /// again.
  void append_whole(std::string_view text);

  /// Writes all bytes at `offset` [bytes], however many there are.
  void write_at(std::int64_t offset, std::span<const std::byte> bytes);

  /// Reserves disk space, so that `num_bytes` from `offset` on can be written, or fails and leaves the file's size
  /// unchanged. Never shortens the file.
  void reserve(std::int64_t offset, std::int64_t num_bytes);

  /// Truncates the file (or extends it with zeros) to `num_bytes`.
  void resize(std::int64_t num_bytes);

  /// Size [bytes].
  std::int64_t size() const;

  /// Returns when the data are on disk.
  void sync();
  void close();

 private:
  [[noreturn]] void fail(int error) const;

  std::filesystem::path path_;
  int descriptor_ = -1;
};

/// What a write survives: the end of this process at any moment, or a power failure too. For the latter the data are
/// synced to disk, which takes milliseconds.
enum class Durability { process, power };

/// Replaces `file` by `text` so that a reader, or a run killed at any moment, sees either the old text or the new one:
/// written as `<file>.part`, then renamed. A device or a pipe is written to directly.
void write_text_atomically(const std::filesystem::path& file, std::string_view text,
                           Durability durability = Durability::power);

/// Renames a file and replaces the one of the new name. FileError if that is a device or a pipe.
void replace_file(const std::filesystem::path& from, const std::filesystem::path& to,
                  Durability durability = Durability::power);

/// Creates the directory and its parents; it may exist.
void make_directory(const std::filesystem::path& directory);

/// " (did you mean 'x'?)" for the file of the closest name in the same directory, else empty. Throws nothing.
std::string similar_file(const std::filesystem::path& missing);

/// A lock on a directory: while it lives, no other process can hold it, as far as the directory's file system supports
/// locks between processes. It ends with the process, however that ends.
class DirectoryLock {
 public:
  /// Waits this long for another holder, then throws FileError. Where locks are not supported, nothing is locked.
  DirectoryLock(const std::filesystem::path& directory, std::chrono::milliseconds patience);
  DirectoryLock(const DirectoryLock&) = delete;
  DirectoryLock& operator=(const DirectoryLock&) = delete;
  ~DirectoryLock();

 private:
  int descriptor_ = -1;
};

}  // namespace pliant
