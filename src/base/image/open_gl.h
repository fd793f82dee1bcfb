#pragma once

#include <cstdint>

// What is used of OpenGL 1.1 and of Mesa's off-screen interface (OSMesa 22), as their
// specifications declare it. Debian's headers for it bring 47 packages along; the library itself is
// one.

extern "C" {

using GLenum = std::uint32_t;
using GLbitfield = std::uint32_t;
using GLboolean = std::uint8_t;
using GLint = std::int32_t;
using GLsizei = std::int32_t;
using GLfloat = float;
using GLdouble = double;

inline constexpr GLboolean GL_FALSE = 0;
inline constexpr GLboolean GL_TRUE = 1;
inline constexpr GLenum GL_POINTS = 0x0000;
inline constexpr GLenum GL_LINE_STRIP = 0x0003;
inline constexpr GLenum GL_TRIANGLES = 0x0004;
inline constexpr GLenum GL_SRC_ALPHA = 0x0302;
inline constexpr GLenum GL_ONE_MINUS_SRC_ALPHA = 0x0303;
inline constexpr GLenum GL_DEPTH_TEST = 0x0B71;
inline constexpr GLenum GL_BLEND = 0x0BE2;
inline constexpr GLenum GL_UNSIGNED_BYTE = 0x1401;
inline constexpr GLenum GL_MODELVIEW = 0x1700;
inline constexpr GLenum GL_PROJECTION = 0x1701;
inline constexpr GLbitfield GL_DEPTH_BUFFER_BIT = 0x00000100;
inline constexpr GLbitfield GL_COLOR_BUFFER_BIT = 0x00004000;

void glBegin(GLenum mode);
void glBlendFunc(GLenum source, GLenum destination);
void glClear(GLbitfield mask);
void glClearColor(GLfloat red, GLfloat green, GLfloat blue, GLfloat alpha);
void glColor4f(GLfloat red, GLfloat green, GLfloat blue, GLfloat alpha);
void glColor4fv(const GLfloat* color);
void glDepthMask(GLboolean flag);
void glEnable(GLenum capability);
void glEnd();
void glFinish();
void glLineWidth(GLfloat width);
void glLoadMatrixd(const GLdouble* matrix);
void glMatrixMode(GLenum mode);
void glPointSize(GLfloat size);
void glVertex3dv(const GLdouble* vertex);
void glViewport(GLint x, GLint y, GLsizei width, GLsizei height);

struct osmesa_context;
inline constexpr GLenum OSMESA_RGBA = 0x1908;
osmesa_context* OSMesaCreateContextExt(GLenum format, GLint depth_bits, GLint stencil_bits,
                                       GLint accumulation_bits, osmesa_context* shared);
void OSMesaDestroyContext(osmesa_context* context);
GLboolean OSMesaMakeCurrent(osmesa_context* context, void* buffer, GLenum type, GLsizei width,
                            GLsizei height);
osmesa_context* OSMesaGetCurrentContext();

}  // extern "C"
