#include "hdf5.hpp"

#include <mutex>

namespace recon::detail {

namespace {
std::recursive_mutex hdf5_mutex;
}  // namespace

QuietHdf5::QuietHdf5() {
  hdf5_mutex.lock();
  H5Eget_auto2(H5E_DEFAULT, &print_, &data_);
  H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
}

QuietHdf5::~QuietHdf5() {
  H5Eset_auto2(H5E_DEFAULT, print_, data_);
  hdf5_mutex.unlock();
}

}  // namespace recon::detail
