#include "petsc/hdf5.hpp"

#include "base/error.hpp"

#include <algorithm>
#include <utility>

namespace pliant {
namespace {

// Called by HDF5 from the innermost failing function outwards; keeps the innermost reason.
herr_t keep_first(unsigned level, const H5E_error2_t* error, void* text) {
  if (level == 0 && error->desc != nullptr) *static_cast<std::string*>(text) = error->desc;
  return 0;
}

void write_scalar(hid_t object, const std::string& name, hid_t type, const void* value) {
  const std::string doing = "write the attribute '" + name + "'";
  const Hdf5Handle space(H5Screate(H5S_SCALAR), H5Sclose, doing);
  const Hdf5Handle attribute(H5Acreate2(object, name.c_str(), type, space.get(), H5P_DEFAULT, H5P_DEFAULT), H5Aclose,
                             doing);
  check_hdf5(H5Awrite(attribute.get(), type, value), doing);
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
  throw FileError("cannot " + doing + (reason.empty() ? "" : ": " + reason));
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

Hdf5Handle open_hdf5(const std::filesystem::path& file, Hdf5Mode mode) {
  const std::string doing = (mode == Hdf5Mode::create ? "create '" : "open '") + file.string() + "'";
  const Hdf5Handle access(H5Pcreate(H5P_FILE_ACCESS), H5Pclose, doing);
  check_hdf5(H5Pset_file_locking(access.get(), /*use_file_locking=*/false, /*ignore_when_disabled=*/true), doing);
  const std::string path = file.string();
  switch (mode) {
    case Hdf5Mode::read:
      return {H5Fopen(path.c_str(), H5F_ACC_RDONLY, access.get()), H5Fclose, doing};
    case Hdf5Mode::modify:
      return {H5Fopen(path.c_str(), H5F_ACC_RDWR, access.get()), H5Fclose, doing};
    case Hdf5Mode::create:
      break;
  }
  return {H5Fcreate(path.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, access.get()), H5Fclose, doing};
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
  // HDF5 knows no string of size zero; the terminating null is the one byte of an empty one.
  check_hdf5(H5Tset_size(type.get(), std::max<std::size_t>(value.size(), 1)), doing);
  check_hdf5(H5Tset_strpad(type.get(), H5T_STR_NULLPAD), doing);
  check_hdf5(H5Tset_cset(type.get(), H5T_CSET_UTF8), doing);
  write_scalar(object, name, type.get(), value.c_str());
}

}  // namespace pliant
