/// HDF5 with owned handles and checked return codes, used by one rank: nothing here is collective. Files are opened
/// without HDF5's file locks, so that a reader cannot stop the run.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cassert>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <span>
#include <string>
#include <type_traits>
#include <vector>

#include <hdf5.h>

namespace pliant {

/// While it lives, HDF5 prints no error stack: failures are thrown as FileError.
class QuietHdf5 {
 public:
  QuietHdf5();
  ~QuietHdf5();
  QuietHdf5(const QuietHdf5&) = delete;
  QuietHdf5& operator=(const QuietHdf5&) = delete;

 private:
  H5E_auto2_t print_ = nullptr;
  void* data_ = nullptr;
};

/// Throws FileError "cannot <doing>: <HDF5's reason>" if `code` (any HDF5 return value) is negative.
void check_hdf5(std::int64_t code, const std::string& doing);

/// The single owner of an HDF5 object. `close()` closes it before the end of the scope and throws FileError on failure.
class Hdf5Handle {
 public:
  using Closer = herr_t (*)(hid_t);

  Hdf5Handle() = default;
  /// Takes ownership of `id`, the result of an HDF5 call that creates or opens something; throws as check_hdf5 does if
  /// it failed.
  Hdf5Handle(hid_t id, Closer closer, const std::string& doing);
  Hdf5Handle(Hdf5Handle&& other) noexcept;
  Hdf5Handle& operator=(Hdf5Handle&& other) noexcept;
  Hdf5Handle(const Hdf5Handle&) = delete;
  Hdf5Handle& operator=(const Hdf5Handle&) = delete;
  ~Hdf5Handle();

  hid_t get() const { return id_; }
  void close(const std::string& doing);

 private:
  hid_t id_ = H5I_INVALID_HID;
  Closer closer_ = nullptr;
};

enum class Hdf5Mode { read, modify, create };

/// Opens a file on the calling rank alone. `user_block`: size [bytes] of the block before HDF5's own data that a new
/// file leaves to others, 0 or a power of two from 512 on.
Hdf5Handle open_hdf5(const std::filesystem::path& file, Hdf5Mode mode, std::int64_t user_block = 0);

/// Runs `work` on that file in a child process (base/child_process.hpp), because HDF5 crashes on some damaged files,
/// and returns its text. Throws the FileError of `work`; a FileError if the child dies; std::runtime_error for other
/// failures.
std::string hdf5_in_child(const std::filesystem::path& file, const std::function<std::string()>& work);
/// The same for numbers, and structs of them.
template <class Work>
requires std::is_trivially_copyable_v<std::invoke_result_t<Work>>
auto hdf5_in_child(const std::filesystem::path& file, const Work& work) {
  using Result = std::invoke_result_t<Work>;
  std::array<char, sizeof(Result)> bytes{};
  const std::string answer = hdf5_in_child(file, [&] {
    const auto of_child = std::bit_cast<decltype(bytes)>(work());
    return std::string(of_child.begin(), of_child.end());
  });
  assert(answer.size() == bytes.size());
  std::ranges::copy(answer, bytes.begin());
  return std::bit_cast<Result>(bytes);
}

/// Names of the links in a group, in alphabetical order.
std::vector<std::string> names_in(hid_t group);

/// Attributes of a group, dataset or file.
void write_attribute(hid_t object, const std::string& name, double value);
void write_attribute(hid_t object, const std::string& name, std::int64_t value);
void write_attribute(hid_t object, const std::string& name, const std::string& value);
void write_attribute(hid_t object, const std::string& name, std::span<const double> values);
/// An attribute of as many numbers as there are places.
void read_attribute(hid_t object, const std::string& name, std::span<double> values);
/// An attribute of one number. Throws FileError if it is missing or not finite.
double finite_attribute(hid_t object, const std::string& name);

/// Throw FileError if there is no such attribute, or if it is not an integer or not a text.
std::int64_t integer_attribute(hid_t object, const std::string& name);
std::string text_attribute(hid_t object, const std::string& name);

/// Sizes of a dataset, slowest first.
std::vector<hsize_t> sizes_of(hid_t dataset);

/// Rows of a dataset, counted by its slowest index.
struct Hdf5Rows {
  std::int64_t first = 0;
  std::int64_t count = 0;
};

/// Throws FileError "cannot <doing>: ..." if the dataset's file is shorter than so many bytes.
void require_room(hid_t dataset, double bytes, const std::string& doing);

/// Throws FileError "cannot <doing>: ..." if the file holds less than the dataset's sizes say, in chunks that hold less
/// than theirs, or numbers whose bits reach over their ends: HDF5 1.10 would read out of bounds.
void require_stored(hid_t dataset, const std::string& doing);

/// Reads whole rows into `values`, which must have room for them. `type`: of the values in memory.
void read_rows(hid_t dataset, const Hdf5Rows& rows, hid_t type, void* values);

/// Writes a dataset of the given sizes with all its values.
void write_dataset(hid_t parent, const std::string& name, const std::vector<hsize_t>& sizes, hid_t type,
                   const void* values);

}  // namespace pliant
