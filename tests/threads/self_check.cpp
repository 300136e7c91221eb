// Loops over threads that the thread sanitizer must judge rightly: with an argument one that races,
// else a reduction and a critical section that do not.
#include <cstdio>

int main(int count, char**) {
  long sum = 0;
  if (count > 1) {
#pragma omp parallel for num_threads(4)
    for (int i = 0; i < 1000; ++i) sum += i;
  } else {
#pragma omp parallel for num_threads(4) reduction(+ : sum)
    for (int i = 0; i < 1000; ++i) sum += i;
#pragma omp parallel for num_threads(4)
    for (int i = 0; i < 1000; ++i)
#pragma omp critical
      sum += i;
  }
  std::printf("%ld\n", sum);
}
