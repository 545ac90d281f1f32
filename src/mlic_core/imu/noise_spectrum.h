#pragma once

#include <Eigen/Core>
#include <vector>

namespace mlic {

// Periodogram of an evenly sampled signal, with a Hann window: what lies in one band does not reach into
// another. White noise of variance s^2 has the same level s^2 everywhere.
class NoiseSpectrum {
 public:
  // rate: Hz. The last samples, less than a sixteenth of all, may be left out; below 64 there is no spectrum.
  NoiseSpectrum(const Eigen::VectorXd& values, double rate);
  NoiseSpectrum() = default;  // of no samples

  double Nyquist() const { return nyquist_; }  // Hz

  // Variance of what of the signal lies from low to high (Hz).
  double Variance(double low, double high) const;
  // Variance of white noise with the level that the signal has from low to high (Hz), by the median, so that
  // lines of vibration do not count. Zero for an empty band.
  double WhiteVariance(double low, double high) const;

 private:
  std::size_t Bin(double frequency) const;

  double nyquist_ = 0.0;       // Hz
  double step_ = 1.0;          // Hz
  std::size_t count_ = 0;      // of samples
  std::vector<double> level_;  // of each bin from zero to half of the rate
};

// Hz, up to where a spline with knots so far apart (s) follows samples of this rate; at most a quarter of it,
// so that noise is seen as far again beyond.
double TopOfBand(double rate, double knot_spacing);

}  // namespace mlic
