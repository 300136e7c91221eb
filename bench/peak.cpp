#include "peak.hpp"

#include <omp.h>

#include <algorithm>
#include <chrono>
#include <memory>

namespace recon_bench {
namespace {

#if defined(__AVX512F__)
constexpr int vector_bytes = 64, accumulators = 24;  // of 32 registers
#elif defined(__AVX__)
constexpr int vector_bytes = 32, accumulators = 12;  // of 16 registers
#else
constexpr int vector_bytes = 16, accumulators = 12;
#endif
constexpr int fma_steps = 1 << 20;
constexpr int fma_repetitions = 10, memory_repetitions = 5;

double now() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

// x = x * a + b, which converges to 1 whatever x was.
template <class Scalar>
Scalar multiply_add(Scalar a, Scalar b) {
  typedef Scalar Vector __attribute__((vector_size(vector_bytes)));
  Vector x[accumulators];
  for (int i = 0; i < accumulators; ++i) x[i] = Vector{} + Scalar(i);
  for (int step = 0; step < fma_steps; ++step)
#pragma GCC unroll 24
    for (int i = 0; i < accumulators; ++i) x[i] = x[i] * a + b;
  Vector sum{};
  for (int i = 0; i < accumulators; ++i) sum += x[i];
  return sum[0];
}

// The best of several rates, where `work` is done by `body(thread)` on every thread at once.
template <class Body>
double best_rate(double work, int repetitions, int threads, const Body& body) {
  double best = 0;
  for (int r = 0; r < repetitions; ++r) {
    double begin = 0;
#pragma omp parallel num_threads(threads)
    {
#pragma omp barrier
#pragma omp master
      begin = now();
#pragma omp barrier
      body(omp_get_thread_num());
    }
    best = std::max(best, work / (now() - begin));
  }
  return best;
}

// Each thread's own part of an array of n.
std::size_t border(std::size_t n, int thread, int threads) {
  return n * static_cast<std::size_t>(thread) / static_cast<std::size_t>(threads);
}

using Array = std::unique_ptr<double[]>;

Array filled(std::size_t n, double value, int threads) {
  Array array(new double[n]);
#pragma omp parallel num_threads(threads)
  {
    const int t = omp_get_thread_num();
    std::fill(array.get() + border(n, t, threads), array.get() + border(n, t + 1, threads), value);
  }
  return array;
}

volatile double sink;

}  // namespace

template <class Scalar>
double measured_flops(int threads) {
  volatile Scalar a = Scalar(0.5), b = Scalar(0.5);
  const double work = 2.0 * fma_steps * accumulators * (vector_bytes / sizeof(Scalar)) * threads;
  return best_rate(work, fma_repetitions, threads,
                   [&](int) { sink = static_cast<double>(multiply_add<Scalar>(a, b)); });
}

double measured_read_bandwidth(std::size_t bytes, int threads) {
  const std::size_t n = bytes / sizeof(double);
  const Array array = filled(n, 1, threads);
  return best_rate(static_cast<double>(n * sizeof(double)), memory_repetitions, threads,
                   [&](int t) {
                     typedef double Vector __attribute__((vector_size(vector_bytes), aligned(8)));
                     constexpr std::size_t lanes = vector_bytes / sizeof(double);
                     Vector sum[8] = {};
                     std::size_t i = border(n, t, threads);
                     for (const std::size_t end = border(n, t + 1, threads); i + 8 * lanes <= end;
                          i += 8 * lanes)
                       for (std::size_t j = 0; j < 8; ++j)
                         sum[j] += *reinterpret_cast<const Vector*>(array.get() + i + j * lanes);
                     for (int j = 1; j < 8; ++j) sum[0] += sum[j];
                     sink = sum[0][0];
                   });
}

double measured_triad_bandwidth(std::size_t bytes, int threads) {
  const std::size_t n = bytes / sizeof(double);
  const Array a = filled(n, 0, threads), b = filled(n, 1, threads), c = filled(n, 2, threads);
  return best_rate(3.0 * static_cast<double>(n * sizeof(double)), memory_repetitions, threads,
                   [&](int t) {
                     const std::size_t end = border(n, t + 1, threads);
                     double* __restrict out = a.get();
                     for (std::size_t i = border(n, t, threads); i < end; ++i)
                       out[i] = b[i] + 3 * c[i];
                   });
}

int native_vector_bytes() {
  return vector_bytes;
}

template double measured_flops<float>(int);
template double measured_flops<double>(int);

}  // namespace recon_bench
