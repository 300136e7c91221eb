// The kernels of one target in the threads of a GPU, against the same code on the host.
//
// Ten thousand targets with neighbours of their own: random clouds, and among them planes, lines,
// clusters, few particles and copies of one, which take every path of the graded Gram-Schmidt. Each
// is fitted by the moment matrix and by Gram-Schmidt, with memory of compile-time size and with
// memory handed in. Printed are the largest differences, relative to the largest number of their kind
// of the target, and the times. The exit status is 1 where such a difference exceeds what rounding
// may do, 64 eps a / s with the amplification a >= 1 and the smallest pivot s of the report, or a
// report differs in what was kept, and 77 where there is no GPU. (A host that fuses products and
// sums, and one that does not, differ as much: by 2e-10 in a cluster with s = 2e-7.)
//
// A device may handle a target by the other path of two that agree (a pivot beside its threshold):
// that is counted, and the numbers must agree all the same.
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <limits>
#include <random>
#include <vector>

#include "recon/shape/target_shapes.hpp"

namespace {

constexpr int D = 3, targets = 10'000, most = 24;
constexpr int numbers = recon::detail::jet_size(D);  // phi and its derivatives

using Terms = recon::Monomials<D, 2>;
using Weight = recon::BSpline<3>;
using Fixed = recon::TargetShapes<Terms, Weight, double, recon::RoomFor<most>>;
using Handed = recon::TargetShapes<Terms, Weight, double, recon::Given>;
constexpr std::size_t bytes = Handed::bytes_for(most);

void check(cudaError_t error, const char* what) {
  if (error == cudaSuccess) return;
  std::fprintf(stderr, "%s: %s\n", what, cudaGetErrorString(error));
  std::exit(1);
}
#define CHECK(call) check(call, #call)

// The clouds, and what is made of them: out[(t * most + i) * numbers + j] is phi or derivative j of
// neighbour i of target t.
struct Task {
  const double* at;      // [target][neighbour][axis]
  const int* count;      // of neighbours
  const double* target;  // [target][axis]
  double* out;
  recon::FitReport* reports;
  std::byte* memory;  // of the threads, `bytes` each; null: memory of compile-time size
  recon::Solver solver;
};

template <class Shapes>
__host__ __device__ void fit(const Task& task, int t, Shapes& shapes) {
  const double* x = task.target + t * D;
  const double* near = task.at + t * most * D;
  double* out = task.out + static_cast<std::size_t>(t) * most * numbers;
  for (int i = 0; i < most * numbers; ++i) out[i] = 0;
  task.reports[t] = shapes.fit({x[0], x[1], x[2]}, 1.0, task.count[t], [&](int i) {
    return std::array<double, D>{near[i * D] - x[0], near[i * D + 1] - x[1],
                                 near[i * D + 2] - x[2]};
  });
  const auto phi = shapes.arrays();
  for (int p = 0; p < shapes.size(); ++p) {
    double* row = out + shapes.place(p) * numbers;
    row[0] = phi.value[p];
    for (int d = 0; d < D; ++d) row[1 + d] = phi.gradient[d][p];
    for (int e = 0; e < D * (D + 1) / 2; ++e) row[1 + D + e] = phi.hessian[e][p];
  }
}

__host__ __device__ void fit(const Task& task, int t) {
  if (task.memory == nullptr) {
    Fixed shapes(Weight{}, task.solver);
    fit(task, t, shapes);
  } else {
    recon::Workspace workspace({task.memory + static_cast<std::size_t>(t) * bytes, bytes});
    Handed shapes(Weight{}, task.solver, recon::WeightForm::radial, {}, {workspace, most});
    fit(task, t, shapes);
  }
}

__global__ void __launch_bounds__(64) fit_all(Task task) {
  const int t = static_cast<int>(blockIdx.x * blockDim.x + threadIdx.x);
  if (t < targets) fit(task, t);
}

struct Clouds {
  std::vector<double> at, target;
  std::vector<int> count;
};

Clouds make_clouds() {
  std::mt19937_64 random(7);
  std::uniform_real_distribution<double> in(-0.55, 0.55);
  Clouds clouds;
  for (int t = 0; t < targets; ++t) {
    const int kind = t % 10;
    double x[D];
    for (double& c : x) clouds.target.push_back(c = 10 * in(random));
    const double normal[D] = {0.6 + 0.1 * in(random), -0.64, 0.48};
    clouds.count.push_back(kind == 8 ? t / 10 % 6 : most);
    for (int i = 0; i < most; ++i) {
      double y[D] = {in(random), in(random), in(random)};
      const double along = y[0];
      double off = 0, length2 = 0;
      for (int d = 0; d < D; ++d) {
        off += normal[d] * y[d];
        length2 += normal[d] * normal[d];
      }
      for (int d = 0; d < D; ++d) {
        if (kind == 5) y[d] -= off / length2 * normal[d];  // a plane
        if (kind == 6) y[d] = along * normal[d];           // a line
        if (kind == 7 && i > 3) y[d] = 0.2 + 1e-3 * y[d];  // a cluster
        if (kind == 9) y[d] = 0.3;                         // one place
        clouds.at.push_back(x[d] + y[d]);
      }
    }
  }
  return clouds;
}

// The largest difference of a target relative to its largest number of the kind; and the same in
// units of what rounding may do.
struct Difference {
  double largest = 0, of_bound = 0;
};
Difference compare(const std::vector<double>& host, const std::vector<double>& device,
                   const std::vector<recon::FitReport>& reports, int kind) {
  Difference worst;
  for (std::size_t t = 0; t < targets; ++t) {
    double largest = 0, difference = 0;
    for (std::size_t i = 0; i < most; ++i) {
      const int first = kind == 0 ? 0 : kind == 1 ? 1 : 1 + D;
      const int last = kind == 0 ? 1 : kind == 1 ? 1 + D : numbers;
      for (int j = first; j < last; ++j) {
        const std::size_t place = (t * most + i) * numbers + static_cast<std::size_t>(j);
        largest = std::fmax(largest, std::fabs(host[place]));
        const double apart = std::fabs(host[place] - device[place]);
        if (!(apart <= difference)) difference = apart;  // NaN too
      }
    }
    if (difference == 0) continue;
    const double relative = difference / largest;
    const double bound = 64 * std::numeric_limits<double>::epsilon() *
                         std::fmax(1.0, static_cast<double>(reports[t].amplification)) /
                         static_cast<double>(reports[t].smallest_pivot);
    if (!(relative <= worst.largest)) worst.largest = relative;
    if (!(relative <= worst.of_bound * bound)) worst.of_bound = relative / bound;
  }
  return worst;
}

template <class T>
T* on_device(std::size_t count) {
  T* memory = nullptr;
  CHECK(cudaMalloc(&memory, count * sizeof(T)));
  return memory;
}

}  // namespace

int main() {
  int devices = 0;
  if (cudaGetDeviceCount(&devices) != cudaSuccess || devices == 0) {
    std::puts("no GPU: the kernels were compiled for one, and not run");
    return 77;
  }
  cudaDeviceProp properties;
  CHECK(cudaGetDeviceProperties(&properties, 0));
  std::printf("%s: %d targets in %d-D, degree 2, up to %d neighbours\n", properties.name, targets,
              D, most);
  const Clouds clouds = make_clouds();
  const std::size_t size = std::size_t{targets} * most * numbers;
  std::vector<double> host(size), device(size);
  std::vector<recon::FitReport> host_reports(targets), device_reports(targets);
  std::vector<std::byte> host_memory(targets * bytes);

  auto* at = on_device<double>(clouds.at.size());
  auto* target = on_device<double>(clouds.target.size());
  auto* count = on_device<int>(clouds.count.size());
  auto* out = on_device<double>(size);
  auto* reports = on_device<recon::FitReport>(targets);
  auto* memory = on_device<std::byte>(targets * bytes);
  const auto copy = [](auto* to, const auto* from, std::size_t n, cudaMemcpyKind kind) {
    CHECK(cudaMemcpy(to, from, n * sizeof(*to), kind));
  };
  copy(at, clouds.at.data(), clouds.at.size(), cudaMemcpyHostToDevice);
  copy(target, clouds.target.data(), clouds.target.size(), cudaMemcpyHostToDevice);
  copy(count, clouds.count.data(), clouds.count.size(), cudaMemcpyHostToDevice);

  bool good = true;
  for (const recon::Solver solver : {recon::Solver::moment_matrix, recon::Solver::gram_schmidt})
    for (const bool handed : {false, true}) {
      const Task here{clouds.at.data(),
                      clouds.count.data(),
                      clouds.target.data(),
                      host.data(),
                      host_reports.data(),
                      handed ? host_memory.data() : nullptr,
                      solver};
      const auto begin = std::chrono::steady_clock::now();
      for (int t = 0; t < targets; ++t) fit(here, t);
      const std::chrono::duration<double, std::nano> host_time =
          std::chrono::steady_clock::now() - begin;

      const Task there{at, count, target, out, reports, handed ? memory : nullptr, solver};
      cudaEvent_t started, ended;
      CHECK(cudaEventCreate(&started));
      CHECK(cudaEventCreate(&ended));
      float best = 1e30f;
      for (int turn = 0; turn < 5; ++turn) {
        CHECK(cudaEventRecord(started));
        fit_all<<<(targets + 63) / 64, 64>>>(there);
        CHECK(cudaGetLastError());
        CHECK(cudaEventRecord(ended));
        CHECK(cudaEventSynchronize(ended));
        float took = 0;
        CHECK(cudaEventElapsedTime(&took, started, ended));
        best = std::fmin(best, took);
      }
      copy(device.data(), out, size, cudaMemcpyDeviceToHost);
      copy(device_reports.data(), reports, targets, cudaMemcpyDeviceToHost);

      int kept = 0, by_the_other_solver = 0;
      for (int t = 0; t < targets; ++t) {
        const recon::FitReport &a = host_reports[t], &b = device_reports[t];
        kept += !(a.kept == b.kept && a.status == b.status && a.neighbours == b.neighbours &&
                  a.gradient_rank == b.gradient_rank && a.hessian_rank == b.hessian_rank);
        by_the_other_solver += a.solver != b.solver;
      }
      const Difference value = compare(host, device, host_reports, 0),
                       gradient = compare(host, device, host_reports, 1),
                       hessian = compare(host, device, host_reports, 2);
      const double of_bound =
          std::fmax(value.of_bound, std::fmax(gradient.of_bound, hessian.of_bound));
      std::printf(
          "%-14s memory %-17s largest difference: values %.1e, gradients %.1e, Hessians %.1e, %.3f of "
          "what rounding may do; reports %d, by the other solver %d; %.1f ns a target on the device, "
          "%.0f on one thread of the host\n",
          recon::name_of(solver).data(), handed ? "handed in," : "of compile time,", value.largest,
          gradient.largest, hessian.largest, of_bound, kept, by_the_other_solver, 1e6 * best / targets,
          host_time.count() / targets);
      good = good && of_bound <= 1 && kept == 0;
    }
  for (void* each :
       {static_cast<void*>(at), static_cast<void*>(target), static_cast<void*>(count),
        static_cast<void*>(out), static_cast<void*>(reports), static_cast<void*>(memory)})
    CHECK(cudaFree(each));
  std::puts(good ? "equal" : "NOT EQUAL: differences beyond rounding, or other reports");
  return good ? 0 : 1;
}
