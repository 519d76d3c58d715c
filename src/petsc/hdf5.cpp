#include "petsc/hdf5.hpp"

#include "base/child_process.hpp"
#include "base/error.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <string_view>
#include <utility>

namespace pliant {
namespace {

// Called by HDF5 from the innermost failing function outwards; stores the innermost reason.
herr_t keep_first(unsigned level, const H5E_error2_t* error, void* text) {
  if (level == 0 && error->desc != nullptr) *static_cast<std::string*>(text) = error->desc;
  return 0;
}

// HDF5's file drivers wrap the system's error text in the time (with a line break), the file's name and numbers.
std::string in_short(const std::string& description) {
  constexpr std::string_view before = "error message = '";
  const std::size_t found = description.find(before);
  if (found == std::string::npos) return description;
  const std::size_t begin = found + before.size();
  return description.substr(begin, description.find("',", begin) - begin);
}

void write_scalar(hid_t object, const std::string& name, hid_t type, const void* value) {
  const std::string doing = "write the attribute '" + name + "'";
  const Hdf5Handle space(H5Screate(H5S_SCALAR), H5Sclose, doing);
  const Hdf5Handle attribute(H5Acreate2(object, name.c_str(), type, space.get(), H5P_DEFAULT, H5P_DEFAULT), H5Aclose,
                             doing);
  check_hdf5(H5Awrite(attribute.get(), type, value), doing);
}

/// Each dimension of a chunk must be no larger than the dataset's. Unpacking needs memory for a whole chunk.
void require_pieces_in_rows(hid_t dataset, hid_t creation, const std::string& doing) {
  const std::vector<hsize_t> sizes = sizes_of(dataset);
  std::vector<hsize_t> piece(sizes.size());
  check_hdf5(H5Pget_chunk(creation, static_cast<int>(piece.size()), piece.data()), doing);
  for (std::size_t i = 1; i < sizes.size(); ++i) {
    if (piece[i] > sizes[i]) throw FileError("cannot " + doing + ": its chunks are wider than its rows");
  }
}

/// A damaged file can place the bits of a number outside of it, and HDF5 1.10 then reads there.
void require_usual_numbers(hid_t type, const std::string& doing) {
  const auto is = [type](hid_t usual) { return H5Tequal(type, usual) > 0; };
  const std::size_t size = H5Tget_size(type);
  const H5T_class_t kind = H5Tget_class(type);
  const bool usual_integer = std::has_single_bit(size) && size <= 8 && H5Tget_precision(type) == 8 * size;
  const bool usual_float = is(H5T_IEEE_F64LE) || is(H5T_IEEE_F32LE) || is(H5T_IEEE_F64BE) || is(H5T_IEEE_F32BE);
  if ((kind == H5T_INTEGER && !usual_integer) || (kind == H5T_FLOAT && !usual_float)) {
    throw FileError("cannot " + doing + ": its numbers are neither integers nor IEEE 754 numbers of 1 to 8 bytes");
  }
}

herr_t append_name(hid_t, const char* name, const H5L_info_t*, void* names) {
  static_cast<std::vector<std::string>*>(names)->emplace_back(name);
  return 0;
}

}  // namespace

QuietHdf5::QuietHdf5() {
  (void)H5Eget_auto2(H5E_DEFAULT, &print_, &data_);
  (void)H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
}

QuietHdf5::~QuietHdf5() {
  (void)H5Eset_auto2(H5E_DEFAULT, print_, data_);
}

void check_hdf5(std::int64_t code, const std::string& doing) {
  if (code >= 0) return;
  std::string reason;
  (void)H5Ewalk2(H5E_DEFAULT, H5E_WALK_UPWARD, keep_first, &reason);
  throw FileError("cannot " + doing + (reason.empty() ? "" : ": " + in_short(reason)));
}

Hdf5Handle::Hdf5Handle(hid_t id, Closer closer, const std::string& doing) : id_(id), closer_(closer) {
  check_hdf5(id, doing);
}

Hdf5Handle::Hdf5Handle(Hdf5Handle&& other) noexcept
    : id_(std::exchange(other.id_, H5I_INVALID_HID)), closer_(other.closer_) {}

Hdf5Handle& Hdf5Handle::operator=(Hdf5Handle&& other) noexcept {
  std::swap(id_, other.id_);
  std::swap(closer_, other.closer_);
  return *this;
}

Hdf5Handle::~Hdf5Handle() {
  if (id_ >= 0) (void)closer_(id_);
}

void Hdf5Handle::close(const std::string& doing) {
  const hid_t id = std::exchange(id_, H5I_INVALID_HID);
  if (id >= 0) check_hdf5(closer_(id), doing);
}

Hdf5Handle open_hdf5(const std::filesystem::path& file, Hdf5Mode mode, std::int64_t user_block) {
  const std::string doing = (mode == Hdf5Mode::create ? "create '" : "open '") + file.string() + "'";
  const Hdf5Handle access(H5Pcreate(H5P_FILE_ACCESS), H5Pclose, doing);
  check_hdf5(H5Pset_file_locking(access.get(), /*use_file_locking=*/false, /*ignore_when_disabled=*/true), doing);
  const std::string path = file.string();
  switch (mode) {
    case Hdf5Mode::read:
      if (H5Fis_hdf5(path.c_str()) == 0) throw FileError("'" + path + "' is not an HDF5 file");
      return {H5Fopen(path.c_str(), H5F_ACC_RDONLY, access.get()), H5Fclose, doing};
    case Hdf5Mode::modify:
      return {H5Fopen(path.c_str(), H5F_ACC_RDWR, access.get()), H5Fclose, doing};
    case Hdf5Mode::create:
      break;
  }
  const Hdf5Handle creation(H5Pcreate(H5P_FILE_CREATE), H5Pclose, doing);
  check_hdf5(H5Pset_userblock(creation.get(), static_cast<hsize_t>(user_block)), doing);
  return {H5Fcreate(path.c_str(), H5F_ACC_TRUNC, creation.get(), access.get()), H5Fclose, doing};
}

std::string hdf5_in_child(const std::filesystem::path& file, const std::function<std::string()>& work) {
  enum Outcome : char { done = 'D', refused = 'R', failed = 'F' };
  const ChildEnd end = in_child([&]() -> std::string {
    try {
      return char{done} + work();
    } catch (const FileError& e) {
      return char{refused} + std::string(e.what());
    } catch (const std::exception& e) {
      return char{failed} + std::string(e.what());
    }
  });
  if (!end.answer || end.answer->empty()) {
    throw FileError("'" + file.string() + "' is damaged: the HDF5 library crashed while reading it (" + end.how + ")");
  }
  std::string text = end.answer->substr(1);
  switch (end.answer->front()) {
    case done:
      return text;
    case refused:
      throw FileError(text);
    default:
      throw std::runtime_error(text);
  }
}

std::vector<std::string> names_in(hid_t group) {
  std::vector<std::string> names;
  check_hdf5(H5Literate(group, H5_INDEX_NAME, H5_ITER_INC, nullptr, append_name, &names), "list a group");
  return names;
}

void write_attribute(hid_t object, const std::string& name, double value) {
  write_scalar(object, name, H5T_NATIVE_DOUBLE, &value);
}

void write_attribute(hid_t object, const std::string& name, std::int64_t value) {
  write_scalar(object, name, H5T_NATIVE_INT64, &value);
}

void write_attribute(hid_t object, const std::string& name, const std::string& value) {
  const std::string doing = "write the attribute '" + name + "'";
  const Hdf5Handle type(H5Tcopy(H5T_C_S1), H5Tclose, doing);
  // HDF5 has no string of size zero; the terminating null is the one byte of an empty one.
  check_hdf5(H5Tset_size(type.get(), std::max<std::size_t>(value.size(), 1)), doing);
  check_hdf5(H5Tset_strpad(type.get(), H5T_STR_NULLPAD), doing);
  check_hdf5(H5Tset_cset(type.get(), H5T_CSET_UTF8), doing);
  write_scalar(object, name, type.get(), value.c_str());
}

std::int64_t integer_attribute(hid_t object, const std::string& name) {
  const std::string doing = "read the attribute '" + name + "'";
  const Hdf5Handle attribute(H5Aopen(object, name.c_str(), H5P_DEFAULT), H5Aclose, doing);
  const Hdf5Handle type(H5Aget_type(attribute.get()), H5Tclose, doing);
  const Hdf5Handle space(H5Aget_space(attribute.get()), H5Sclose, doing);
  if (H5Tget_class(type.get()) != H5T_INTEGER || H5Sget_simple_extent_npoints(space.get()) != 1) {
    throw FileError("cannot " + doing + ": it is not an integer");
  }
  require_usual_numbers(type.get(), doing);
  std::int64_t value = 0;
  check_hdf5(H5Aread(attribute.get(), H5T_NATIVE_INT64, &value), doing);
  return value;
}

std::string text_attribute(hid_t object, const std::string& name) {
  const std::string doing = "read the attribute '" + name + "'";
  const Hdf5Handle attribute(H5Aopen(object, name.c_str(), H5P_DEFAULT), H5Aclose, doing);
  const Hdf5Handle type(H5Aget_type(attribute.get()), H5Tclose, doing);
  const Hdf5Handle space(H5Aget_space(attribute.get()), H5Sclose, doing);
  if (H5Tget_class(type.get()) != H5T_STRING || H5Sget_simple_extent_npoints(space.get()) != 1) {
    throw FileError("cannot " + doing + ": it is not a text");
  }
  if (H5Tis_variable_str(type.get()) > 0) {
    char* text = nullptr;
    check_hdf5(H5Aread(attribute.get(), type.get(), &text), doing);
    std::string value = text != nullptr ? text : "";
    (void)H5free_memory(text);
    return value;
  }
  std::string value(H5Tget_size(type.get()), '\0');
  check_hdf5(H5Aread(attribute.get(), type.get(), value.data()), doing);
  return value.substr(0, value.find('\0'));
}

std::vector<hsize_t> sizes_of(hid_t dataset) {
  const Hdf5Handle space(H5Dget_space(dataset), H5Sclose, "read the size of a dataset");
  const int rank = H5Sget_simple_extent_ndims(space.get());
  check_hdf5(rank, "read the size of a dataset");
  std::vector<hsize_t> sizes(static_cast<std::size_t>(rank));
  check_hdf5(H5Sget_simple_extent_dims(space.get(), sizes.data(), nullptr), "read the size of a dataset");
  return sizes;
}

void require_room(hid_t dataset, double bytes, const std::string& doing) {
  const Hdf5Handle file(H5Iget_file_id(dataset), H5Fclose, doing);
  hsize_t size = 0;
  check_hdf5(H5Fget_filesize(file.get(), &size), doing);
  if (static_cast<double>(size) < bytes) throw FileError("cannot " + doing + ": the file is too short for it");
}

void require_stored(hid_t dataset, const std::string& doing) {
  const Hdf5Handle creation(H5Dget_create_plist(dataset), H5Pclose, doing);
  const H5D_layout_t layout = H5Pget_layout(creation.get());
  const Hdf5Handle type(H5Dget_type(dataset), H5Tclose, doing), space(H5Dget_space(dataset), H5Sclose, doing);
  require_usual_numbers(type.get(), doing);
  if (layout == H5D_CHUNKED) require_pieces_in_rows(dataset, creation.get(), doing);
  if (layout != H5D_CONTIGUOUS && layout != H5D_COMPACT) return;
  const double claimed =
      static_cast<double>(H5Tget_size(type.get())) * static_cast<double>(H5Sget_simple_extent_npoints(space.get()));
  const auto stored = static_cast<double>(H5Dget_storage_size(dataset));
  if (stored < claimed) throw FileError("cannot " + doing + ": the file holds only part of it");
  require_room(dataset, claimed, doing);
}

void read_rows(hid_t dataset, const Hdf5Rows& rows, hid_t type, void* values) {
  if (rows.count == 0) return;
  const std::string doing = "read rows of a dataset";
  require_stored(dataset, doing);
  std::vector<hsize_t> count = sizes_of(dataset), start(count.size(), 0);
  start.at(0) = static_cast<hsize_t>(rows.first);
  count.at(0) = static_cast<hsize_t>(rows.count);
  const Hdf5Handle in_file(H5Dget_space(dataset), H5Sclose, doing);
  check_hdf5(H5Sselect_hyperslab(in_file.get(), H5S_SELECT_SET, start.data(), nullptr, count.data(), /*block=*/nullptr),
             doing);
  const Hdf5Handle in_memory(H5Screate_simple(static_cast<int>(count.size()), count.data(), nullptr), H5Sclose, doing);
  check_hdf5(H5Dread(dataset, type, in_memory.get(), in_file.get(), H5P_DEFAULT, values), doing);
}

void write_dataset(hid_t parent, const std::string& name, const std::vector<hsize_t>& sizes, hid_t type,
                   const void* values) {
  const std::string doing = "write the dataset '" + name + "'";
  const Hdf5Handle space(H5Screate_simple(static_cast<int>(sizes.size()), sizes.data(), nullptr), H5Sclose, doing);
  const Hdf5Handle dataset(H5Dcreate2(parent, name.c_str(), type, space.get(), H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT),
                           H5Dclose, doing);
  if (H5Sget_simple_extent_npoints(space.get()) == 0) return;
  check_hdf5(H5Dwrite(dataset.get(), type, H5S_ALL, H5S_ALL, H5P_DEFAULT, values), doing);
}

void write_attribute(hid_t object, const std::string& name, std::span<const double> values) {
  const std::string doing = "write the attribute '" + name + "'";
  const hsize_t size = values.size();
  const Hdf5Handle space(H5Screate_simple(1, &size, nullptr), H5Sclose, doing);
  const Hdf5Handle attribute(H5Acreate2(object, name.c_str(), H5T_NATIVE_DOUBLE, space.get(), H5P_DEFAULT, H5P_DEFAULT),
                             H5Aclose, doing);
  check_hdf5(H5Awrite(attribute.get(), H5T_NATIVE_DOUBLE, values.data()), doing);
}

void read_attribute(hid_t object, const std::string& name, std::span<double> values) {
  const std::string doing = "read the attribute '" + name + "'";
  const Hdf5Handle attribute(H5Aopen(object, name.c_str(), H5P_DEFAULT), H5Aclose, doing);
  const Hdf5Handle type(H5Aget_type(attribute.get()), H5Tclose, doing);
  const Hdf5Handle space(H5Aget_space(attribute.get()), H5Sclose, doing);
  const H5T_class_t kind = H5Tget_class(type.get());
  if (kind != H5T_FLOAT && kind != H5T_INTEGER) throw FileError("cannot " + doing + ": it is not a number");
  require_usual_numbers(type.get(), doing);
  if (H5Sget_simple_extent_npoints(space.get()) != static_cast<hssize_t>(values.size())) {
    throw FileError("cannot " + doing + ": it has another size");
  }
  check_hdf5(H5Aread(attribute.get(), H5T_NATIVE_DOUBLE, values.data()), doing);
}

double finite_attribute(hid_t object, const std::string& name) {
  double value = 0.0;
  read_attribute(object, name, std::span(&value, 1));
  if (!std::isfinite(value)) throw FileError("cannot read the attribute '" + name + "': it is not a finite number");
  return value;
}

}  // namespace pliant
