/* The slider crank by hand in C: one solve, and loops over rows with the sine and cosine of the C library
   or with polynomials that a compiler can take several rows through at once.
   gcc -O3 -march=native -fno-math-errno -fno-trapping-math -shared -fPIC crank.c -o crank.so -lm */
#include <math.h>
#include <stdint.h>

#define AO 3.0
#define AB 8.0
#define OFFSET 2.0
#define OMEGA -15.0
#define ALPHA -10.0
#define RADIAN 0.017453292519943295
#define DEGREE 57.29577951308232
#define ROUND(x) (((x) + 6755399441055744.0) - 6755399441055744.0)

typedef struct { double x, v, omega, a, alpha; } Five;
typedef struct { double sine, cosine; } Circular;

static inline Five rates(double xA, double yA, double dx, double dy)
{
    double xa = -OMEGA * yA, ya = OMEGA * xA;
    double omega = -ya / dx;
    double xa1 = -OMEGA * OMEGA * xA - ALPHA * yA;
    double ya1 = -OMEGA * OMEGA * yA + ALPHA * xA;
    double alpha = (omega * omega * dy - ya1) / dx;
    Five out = {0.0, xa - omega * dy, omega, xa1 - omega * omega * dx - alpha * dy, alpha};
    return out;
}

static inline Five forward(Circular t)
{
    double xA = AO * t.cosine, yA = AO * t.sine, dy = OFFSET - yA;
    double dx = sqrt(AB * AB - dy * dy);
    Five out = rates(xA, yA, dx, dy);
    out.x = xA + dx;
    return out;
}

static inline Circular library(double radians)
{
    Circular t = {sin(radians), cos(radians)};
    return t;
}

/* Degrees, reduced exactly to a quarter turn; the polynomials of fdlibm (Sun Microsystems, 1993). */
static inline Circular own(double degrees)
{
    double quarters = ROUND(degrees * (1.0 / 90.0));
    double r = (degrees - 90.0 * quarters) * RADIAN, z = r * r;
    double s = 1.58969099521155010221e-10;
    s = s * z - 2.50507602534068634195e-08;
    s = s * z + 2.75573137070700676789e-06;
    s = s * z - 1.98412698298579493134e-04;
    s = s * z + 8.33333333332248946124e-03;
    s = s * z - 1.66666666666666324348e-01;
    s = r + r * (z * s);
    double c = -1.13596475577881948265e-11;
    c = c * z + 2.08757232129817482790e-09;
    c = c * z - 2.75573143513906633035e-07;
    c = c * z + 2.48015872894767294178e-05;
    c = c * z - 1.38888888888741095749e-03;
    c = c * z + 4.16666666666666019037e-02;
    c = 1.0 - (0.5 * z - z * (z * c));
    double turn = quarters - 4.0 * ROUND(quarters * 0.25);
    double across = turn * (2.0 - fabs(turn)), along = 1.0 - fabs(turn);
    Circular t = {s * along + c * across, c * along - s * across};
    return t;
}

/* Arc tangent of y/x in degrees for x > 0, by the polynomial of fdlibm within 22.5 degrees. */
static inline double direction(double y, double x)
{
    double ay = fabs(y), steep = ay > x;
    double t = steep ? x / ay : ay / x;
    double far = t > 0.41421356237309503;
    double u = far ? (t - 1.0) / (t + 1.0) : t, z = u * u;
    double p = 1.62858201153657823623e-02;
    p = p * z - 3.65315727442169155270e-02;
    p = p * z + 4.97687799461593236017e-02;
    p = p * z - 5.83357013379057348645e-02;
    p = p * z + 6.66107313738753120669e-02;
    p = p * z - 7.69187620504482999495e-02;
    p = p * z + 9.09088713343650656196e-02;
    p = p * z - 1.11111104054623557880e-01;
    p = p * z + 1.42857142725034663711e-01;
    p = p * z - 1.99999999998764832476e-01;
    p = p * z + 3.33333333333329318027e-01;
    double angle = (u - u * (z * p)) * DEGREE + (far ? 45.0 : 0.0);
    angle = steep ? 90.0 - angle : angle;
    return copysign(angle, y);
}

static inline Five backward(double x, double sign)
{
    double distance = hypot(x, OFFSET);
    double psi = atan2(OFFSET, x);
    double swing = acos((AO * AO + distance * distance - AB * AB) / (2.0 * AO * distance));
    double radians = psi + sign * swing;
    Circular t = library(radians);
    double xA = AO * t.cosine, yA = AO * t.sine;
    Five out = rates(xA, yA, x - xA, OFFSET - yA);
    out.x = radians * DEGREE;
    return out;
}

/* The lesser of the two angles without its sine and cosine: they follow from the triangle. For x > 0. */
static inline Five backward_own(double x)
{
    double square = x * x + OFFSET * OFFSET, k = (square + AO * AO - AB * AB) / 2.0;
    double h = sqrt(square * AO * AO - k * k);
    double xA = (x * k + OFFSET * h) / square, yA = (OFFSET * k - x * h) / square;
    Five out = rates(xA, yA, x - xA, OFFSET - yA);
    double turned = direction(yA, fabs(xA));
    out.x = xA < 0.0 ? copysign(180.0, yA) - turned : turned;
    return out;
}

void forward_one(double theta, Five *out) { *out = forward(library(theta * RADIAN)); }

void backward_one(double x, Five *out)
{
    out[0] = backward(x, -1.0);
    out[1] = backward(x, 1.0);
}

#define ROWS(name, expression)                                                                               \
    void name(int64_t from, int64_t to, const double *restrict in, double *restrict a, double *restrict b,   \
              double *restrict c, double *restrict d, double *restrict e)                                    \
    {                                                                                                        \
        for (int64_t i = from; i < to; i++) {                                                                \
            Five out = expression;                                                                           \
            a[i] = out.x, b[i] = out.v, c[i] = out.omega, d[i] = out.a, e[i] = out.alpha;                    \
        }                                                                                                    \
    }

ROWS(forward_rows_library, forward(library(in[i] * RADIAN)))
ROWS(forward_rows_own, forward(own(in[i])))
ROWS(backward_rows_library, backward(in[i], -1.0))
ROWS(backward_rows_own, backward_own(in[i]))
